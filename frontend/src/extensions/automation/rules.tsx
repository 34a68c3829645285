import type { LiveGoal } from "@dock-gateway/client";
import { Anchor } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { useCallback, useEffect } from "react";
import { Link } from "react-router";
import type { Base } from "../../api/version";
import { useFleet, useFleetEvent, useFleetLive } from "../../fleet/context";
import { useAnswer, useCommand } from "../../ui/requests";
import {
  type Decision,
  deleteRule,
  endHold,
  listDecisions,
  listRules,
  putRule,
  type Rule,
  type RuleBody,
} from "./requests";

const KEY = ["automation"] as const;
const RULES = [...KEY, "rules"] as const;
/** How often it is asked what rules wait for, and what others have changed (ms). */
const REFETCH_MS = 5000;

/** The rules, as they are now. @param refetchMs How often they are asked for. */
export function useRules(refetchMs = REFETCH_MS) {
  const { http } = useFleet();
  const live = useFleetLive();
  return useAnswer({
    queryKey: RULES,
    queryFn: () => listRules(http),
    enabled: live,
    refetchInterval: refetchMs,
  });
}

/** The latest decisions of all rules. */
export function useDecisions() {
  const { http } = useFleet();
  return useAnswer({
    queryKey: [...KEY, "decisions"],
    queryFn: () => listDecisions(http),
  });
}

/** The decision that sent a goal; null while it is not known. */
function useDecisionOf(goalId: string): Decision | null {
  const { http } = useFleet();
  const { data } = useAnswer({
    queryKey: [...KEY, "goal", goalId],
    queryFn: async () => (await listDecisions(http, goalId))[0] ?? null,
  });
  return data ?? null;
}

/** Asks again for rules and decisions whenever the gateway tells of a decision, or is back. */
export function useFreshAutomation(): void {
  const client = useQueryClient();
  const live = useFleetLive();
  const renew = useCallback(() => void client.invalidateQueries({ queryKey: KEY }), [client]);
  useFleetEvent("automation", renew);
  useEffect(() => {
    if (live) renew();
  }, [live, renew]);
}

/** What changes rules. */
export function useRuleCommands() {
  const { http } = useFleet();
  const client = useQueryClient();
  const change = async (edit: (rules: Rule[]) => Rule[]) => {
    await client.cancelQueries({ queryKey: RULES }); // what it reads is outdated
    client.setQueryData<Rule[]>(RULES, (rules) => edit(rules ?? []));
    void client.invalidateQueries({ queryKey: KEY });
  };
  /** What someone else has changed has to be there when it is said. */
  const renewed = async (error: unknown) => {
    await client.invalidateQueries({ queryKey: RULES });
    throw error;
  };
  const save = useCommand(async ({ id, body, base }: { id: string; body: RuleBody; base: Base }) => {
    const saved = await putRule(http, id, body, base).catch(renewed);
    await change((rules) =>
      [...rules.filter((rule) => rule.id !== id), saved].sort((a, b) => a.name.localeCompare(b.name)),
    );
  });
  const remove = useCommand(async (removed: Rule) => {
    await deleteRule(http, removed).catch(renewed);
    await change((rules) => rules.filter(({ id }) => id !== removed.id));
  });
  const goOn = useCommand(async (robot: string) => {
    await endHold(http, robot);
    await client.invalidateQueries({ queryKey: RULES });
  });
  return { save, remove, goOn };
}

/** Whether a rule waits until someone lets it go on with a robot. */
export function isStopped({ waits_for }: Rule["applies_to"][number]): boolean {
  return waits_for === "stopped";
}

/** The rules that dock a robot by themselves; nothing where there are none. */
export function RobotRules({ robot }: { robot: string }) {
  const { data: rules = [] } = useRules(30_000);
  const on = rules.filter(
    ({ mode, applies_to }) => mode === "on" && applies_to.some((each) => each.robot === robot),
  );
  if (on.length === 0) return null;
  const stopped = on.some(({ applies_to }) =>
    applies_to.some((each) => each.robot === robot && isStopped(each)),
  );
  return (
    <Anchor component={Link} to="/ui/automation" size="sm">
      {stopped ? "Automatic docking waits to be continued" : "Automatic docking on"} (
      {on.map(({ name }) => name).join(", ")})
    </Anchor>
  );
}

/** The rule that sent a goal; nothing for other goals. */
export function GoalRule({ goal }: { goal: LiveGoal }) {
  return goal.origin === "automation" && <RuleLink goalId={goal.goal_id} />;
}

/** A link to the rule that sent a goal, once it is known. */
function RuleLink({ goalId }: { goalId: string }) {
  const decision = useDecisionOf(goalId);
  if (decision === null) return null;
  return (
    <Anchor component={Link} to="/ui/automation">
      Automatic docking: {decision.rule_name}
    </Anchor>
  );
}
