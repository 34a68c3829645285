import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { type Base, ifUnchanged } from "../../../api/version";

/** A mission with parameters. */
export type Template = components["schemas"]["Template"];
export type TemplateBody =
  paths["/mission-templates/{template_id}"]["put"]["requestBody"]["content"]["application/json"];

export async function listTemplates(http: Http): Promise<Template[]> {
  return (await settle(http.GET("/mission-templates", { signal: deadline() }))).templates;
}

/** @param base The template that it replaces, as it was read. */
export function putTemplate(http: Http, id: string, body: TemplateBody, base: Base): Promise<Template> {
  const params = { path: { template_id: id }, header: ifUnchanged(base) };
  return settle(http.PUT("/mission-templates/{template_id}", { params, body, signal: deadline() }));
}

export async function deleteTemplate(http: Http, template: { id: string; etag: string }): Promise<void> {
  const params = { path: { template_id: template.id }, header: ifUnchanged(template) };
  await settle(http.DELETE("/mission-templates/{template_id}", { params, signal: deadline() }));
}
