import { type Approval, deadline, type Http, settle } from "@dock-gateway/client";

/** Allows or refuses the goal of an agent that waits for it; throws a ClientError where it does not wait any more. */
export function answerApproval(http: Http, approval_id: string, allow: boolean): Promise<Approval> {
  const params = { path: { approval_id } };
  return settle(http.POST("/approvals/{approval_id}", { body: { allow }, params, signal: deadline() }));
}
