import { type components, deadline, type Http, settle } from "@dock-gateway/client";

/** The extensions of the gateway, each with the path of its card's module; null for no card. */
export type ExtensionList = components["schemas"]["ExtensionList"];

/** Every failure is a ClientError. */
export function listExtensions(http: Http): Promise<ExtensionList> {
  return settle(http.GET("/extensions", { signal: deadline() }));
}
