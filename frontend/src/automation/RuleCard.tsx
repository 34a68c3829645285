import { SegmentedControl } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { ownName } from "../access/who";
import type { Rule, RuleMode } from "../api/automation";
import { useNaming, useWhyNot } from "../fleet/context";
import { robotsWords } from "../fleet/robotChoice";
import { EntryCard } from "../ui/EntryCard";
import { CommandErrorAlert } from "../ui/errors";
import { withMode } from "./draft";
import { RobotWaits } from "./RobotWaits";
import { SwitchOn } from "./SwitchOn";
import { useRuleCommands } from "./useAutomation";
import { conditionWords, MODES } from "./words";

const MODE_OPTIONS = Object.entries(MODES).map(([value, label]) => ({ value, label }));

/** A rule: when it docks which robots, and its mode to choose. */
export function RuleCard({ rule, onEdit }: { rule: Rule; onEdit: () => void }) {
  const naming = useNaming();
  const reason = useWhyNot("PUT /automation/rules/{rule_id}");
  const { save, remove } = useRuleCommands();
  const [asking, ask] = useDisclosure(false);
  const setMode = (mode: RuleMode, by = ownName().trim() || null) =>
    save.mutate({ id: rule.id, body: withMode(rule, mode, by) });
  const choose = (value: string) => {
    const mode = value as RuleMode;
    if (mode === "on" && rule.mode !== "on") ask.open();
    else if (mode !== rule.mode) setMode(mode);
  };
  return (
    <EntryCard
      entry={rule}
      words={[conditionWords(rule), robotsWords(rule.robots, naming)]}
      control={
        <SegmentedControl
          aria-label={`Mode of ${rule.name}`}
          data={MODE_OPTIONS}
          value={rule.mode}
          onChange={choose}
          disabled={reason !== null || save.isPending}
          title={reason ?? undefined}
          {...(rule.mode === "on" ? { color: "green.9" } : {})}
        />
      }
      reason={reason}
      onEdit={onEdit}
      remove={remove}
      removal="Goals that it has sent go on. Its decisions stay in the list."
    >
      <RobotWaits rule={rule} />
      <CommandErrorAlert command="Saving" error={save.error} onClose={save.reset} />
      <SwitchOn
        rule={rule}
        opened={asking}
        onClose={ask.close}
        onSwitch={(by) => {
          ask.close();
          setMode("on", by);
        }}
      />
    </EntryCard>
  );
}
