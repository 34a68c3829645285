import { Anchor, Badge, Group, Skeleton, Stack, Table, Text } from "@mantine/core";
import { useState } from "react";
import { Link } from "react-router";
import { useFleetLive, useNaming, useWhyNot } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { Dialog } from "../../ui/Dialog";
import { Empty } from "../../ui/Empty";
import { Trouble } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { PageTitle, Section } from "../../ui/Section";
import { Time } from "../../ui/Time";
import { useZone } from "../../ui/zone";
import classes from "./automation.module.css";
import { type Draft, EXAMPLES } from "./draft";
import { RuleCard } from "./RuleCard";
import { RuleForm } from "./RuleForm";
import type { Decision, Rule } from "./requests";
import { useDecisions, useFreshAutomation, useRules } from "./rules";
import { OUTCOMES, reasonWords } from "./words";

/** The rule in the dialog; null for a new one, which may start from an example. */
type Edited = { rule: Rule | null; example?: Partial<Draft> };

/** The rules of automatic docking, and what they have decided. */
export default function AutomationPage() {
  useFreshAutomation();
  const { data: rules, error, refetch } = useRules();
  const reason = useWhyNot("PUT /automation/rules/{rule_id}", rules !== undefined);
  const [edited, setEdited] = useState<Edited | null>(null);
  const close = () => setEdited(null);
  return (
    <Stack gap="md">
      <PageTitle title="Automatic docking" help="extensions/automation#when-a-rule-docks-a-robot">
        <ReasonButton reason={reason} onClick={() => setEdited({ rule: null })}>
          New rule
        </ReasonButton>
      </PageTitle>
      <Trouble what="The rules could not be loaded" error={error} onRetry={() => void refetch()} />
      {rules === undefined ? (
        error === null && <RulesSkeleton />
      ) : rules.length === 0 ? (
        <NoRules reason={reason} onExample={(example) => setEdited({ rule: null, example })} />
      ) : (
        <Stack component="ul" gap="sm" m={0} p={0} aria-label="Rules">
          {rules.map((rule) => (
            <RuleCard key={rule.id} rule={rule} onEdit={() => setEdited({ rule })} />
          ))}
        </Stack>
      )}
      <Decisions />
      <Dialog
        opened={edited !== null}
        onClose={close}
        title={edited?.rule ? `Edit ${edited.rule.name}` : "New rule"}
      >
        {edited !== null && (
          <RuleForm rule={edited.rule} example={edited.example} rules={rules ?? []} onDone={close} />
        )}
      </Dialog>
    </Stack>
  );
}

interface NoRulesProps {
  /** Why none can be added now; null where one can. */
  reason: string | null;
  onExample: (draft: Partial<Draft>) => void;
}

function NoRules({ reason, onExample }: NoRulesProps) {
  return (
    <Empty
      title="No rules"
      examples={EXAMPLES.map(({ label, draft }) => (
        <ReasonButton key={label} variant="default" reason={reason} onClick={() => onExample(draft)}>
          Example: {label}
        </ReasonButton>
      ))}
    >
      A rule sends robots to their docks by itself: those that stand idle with a low battery, or all of them
      at 22:00. A new rule is off. In a dry run it only records what it would do.
    </Empty>
  );
}

function RulesSkeleton() {
  return (
    <Stack gap="sm" role="status" aria-busy="true" aria-label="The rules are loading">
      <Skeleton height={110} />
      <Skeleton height={110} />
    </Stack>
  );
}

/** The latest decisions as they come. */
function Decisions() {
  const { data: decisions, error, refetch } = useDecisions();
  const live = useFleetLive();
  return (
    <Section
      title="Latest decisions"
      help="extensions/automation#what-was-decided-and-why"
      aside={
        <Text size="sm" c="dimmed" role="status">
          {live ? "Live" : "Not live"}
        </Text>
      }
    >
      <Trouble what="The decisions could not be loaded" error={error} onRetry={() => void refetch()} />
      {decisions === undefined ? (
        error === null && <Skeleton height={80} />
      ) : decisions.length === 0 ? (
        <Text size="sm" c="dimmed">
          Each decision of a rule that is on or in a dry run is listed here, with its reason.
        </Text>
      ) : (
        <DecisionTable decisions={decisions} />
      )}
    </Section>
  );
}

function DecisionTable({ decisions }: { decisions: readonly Decision[] }) {
  return (
    <Table verticalSpacing="xs" horizontalSpacing={8} className={classes.decisions ?? ""}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th className={classes.time}>Time</Table.Th>
          <Table.Th>Robot</Table.Th>
          <Table.Th visibleFrom="sm">Rule</Table.Th>
          <Table.Th>Decision</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {decisions.map((decision) => (
          <DecisionRow key={decision.id} decision={decision} />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function DecisionRow({ decision }: { decision: Decision }) {
  const naming = useNaming();
  useZone();
  const { robot, rule_name, outcome, goal_id, decided_at } = decision;
  const { words, color } = OUTCOMES[outcome];
  return (
    <Table.Tr>
      <Table.Td className={`tabular ${classes.time}`}>
        <Time value={decided_at} />
      </Table.Td>
      <Table.Td className={classes.robot}>
        <Anchor component={Link} to={robotPath(robot)} size="sm" underline="always">
          {naming.nameOf(robot)}
        </Anchor>
        <Text size="xs" c="dimmed" hiddenFrom="sm">
          {rule_name}
        </Text>
      </Table.Td>
      <Table.Td visibleFrom="sm">{rule_name}</Table.Td>
      <Table.Td>
        <Group gap="xs">
          <Badge variant="outline" color={color} className={classes.outcome ?? ""}>
            {words}
          </Badge>
          <Text size="sm">{reasonWords(decision)}</Text>
          {goal_id !== null && (
            <Anchor component={Link} to={`/ui/goals/${goal_id}`} size="sm" underline="always">
              See the goal
            </Anchor>
          )}
        </Group>
      </Table.Td>
    </Table.Tr>
  );
}
