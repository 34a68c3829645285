import { type components, deadline, type Http, type paths, settle } from "@dock-gateway/client";
import { type Base, ifUnchanged } from "../../api/version";

type Schemas = components["schemas"];

/** A rule of automatic docking. */
export type Rule = Schemas["Rule"];
export type RuleMode = Schemas["RuleMode"];
/** What a client says of a rule; the gateway adds who changed it, and the robots that it applies to. */
export type RuleBody =
  paths["/automation/rules/{rule_id}"]["put"]["requestBody"]["content"]["application/json"];
/** What a rule decided about a robot. */
export type Decision = Schemas["Decision"];
/** Why a rule does not dock a robot now. */
export type Wait = Schemas["WaitReason"];

export async function listRules(http: Http): Promise<Rule[]> {
  return (await settle(http.GET("/automation/rules", { signal: deadline() }))).rules;
}

/** @param base The rule that it replaces, as it was read. */
export function putRule(http: Http, id: string, body: RuleBody, base: Base): Promise<Rule> {
  const params = { path: { rule_id: id }, header: ifUnchanged(base) };
  return settle(http.PUT("/automation/rules/{rule_id}", { params, body, signal: deadline() }));
}

export async function deleteRule(http: Http, rule: Rule): Promise<void> {
  const params = { path: { rule_id: rule.id }, header: ifUnchanged(rule) };
  await settle(http.DELETE("/automation/rules/{rule_id}", { params, signal: deadline() }));
}

/** Lets the rules go on with a robot that was stopped. */
export async function endHold(http: Http, robot: string): Promise<void> {
  await settle(http.DELETE("/automation/holds", { params: { query: { robot } }, signal: deadline() }));
}

/** The newest first. @param goalId Only the decision that sent this goal. */
export async function listDecisions(http: Http, goalId?: string): Promise<Decision[]> {
  const query = goalId === undefined ? { limit: 50 } : { goal_id: goalId };
  return (await settle(http.GET("/automation/decisions", { params: { query }, signal: deadline() })))
    .decisions;
}
