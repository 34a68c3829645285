import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { apiPath } from "../../api/site";

/** One request or command, as it was recorded. */
export type AuditRecord = components["schemas"]["AuditRecord"];
export type AuditPage = components["schemas"]["AuditPage"];
/** What `GET /audit` can be narrowed by. */
export type AuditQuery = Omit<NonNullable<paths["/audit"]["get"]["parameters"]["query"]>, "limit" | "cursor">;

const PAGE = 50;

/** Newest first. Every failure is a ClientError. */
export function listAudit(http: Http, query: AuditQuery, cursor: string | null): Promise<AuditPage> {
  return settle(
    http.GET("/audit", {
      params: { query: { ...query, limit: PAGE, ...(cursor === null ? {} : { cursor }) } },
      signal: deadline(),
    }),
  );
}

/** Where the records that a list is narrowed to are downloaded. */
export function auditExportUrl(query: AuditQuery, format: "csv" | "json"): string {
  const parameters = new URLSearchParams({ format });
  for (const [name, value] of Object.entries(query)) parameters.set(name, String(value));
  return apiPath(`/audit/export?${parameters}`);
}
