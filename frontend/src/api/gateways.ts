import { type components, deadline, type Http, settle } from "@dock-gateway/client";

/** A gateway on the same database, and the robots that it serves. */
export type RunningGateway = components["schemas"]["RunningGateway"];

/** The gateways on this one's database, this one first. Every failure is a ClientError. */
export async function listGateways(http: Http): Promise<RunningGateway[]> {
  return (await settle(http.GET("/gateways", { signal: deadline() }))).gateways;
}
