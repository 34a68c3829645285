import { Skeleton, Stack, Text } from "@mantine/core";
import { useState } from "react";
import type { Rule } from "../api/automation";
import { useWhyNot } from "../fleet/context";
import { Dialog } from "../ui/Dialog";
import { Trouble } from "../ui/errors";
import { PageTitle } from "../ui/PageTitle";
import { ReasonButton } from "../ui/ReasonButton";
import { Decisions } from "./Decisions";
import { RuleCard } from "./RuleCard";
import { RuleForm } from "./RuleForm";
import { useFreshAutomation, useRules } from "./useAutomation";

/** The rule in the dialog; null for a new one. */
type Edited = { rule: Rule | null };

/** The rules of automatic docking, and what they have decided. */
export default function AutomationPage() {
  useFreshAutomation();
  const { data: rules, error, refetch } = useRules();
  const reason = useWhyNot("PUT /automation/rules/{rule_id}", rules !== undefined);
  const [edited, setEdited] = useState<Edited | null>(null);
  const close = () => setEdited(null);
  return (
    <Stack gap="md">
      <PageTitle title="Automatic docking">
        <ReasonButton reason={reason} onClick={() => setEdited({ rule: null })}>
          New rule
        </ReasonButton>
      </PageTitle>
      <Trouble what="The rules could not be loaded" error={error} onRetry={() => void refetch()} />
      {rules === undefined ? (
        error === null && <RulesSkeleton />
      ) : rules.length === 0 ? (
        <NoRules />
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
        {edited !== null && <RuleForm rule={edited.rule} rules={rules ?? []} onDone={close} />}
      </Dialog>
    </Stack>
  );
}

function NoRules() {
  return (
    <Stack gap="xs">
      <Text fw={600}>No rules</Text>
      <Text size="sm" c="dimmed" maw="44rem">
        A rule sends robots to their docks by itself: those that stand idle with a low battery, or all of them
        at 22:00. A new rule is off. In a dry run it only records what it would do.
      </Text>
    </Stack>
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
