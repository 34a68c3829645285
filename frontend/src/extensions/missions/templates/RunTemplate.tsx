import { Button, Group, Stack, Text } from "@mantine/core";
import { type FormEvent, useState } from "react";
import { useNavigate } from "react-router";
import { NameInput, ownName, setOwnName } from "../../../access/who";
import { useFleet, useFleetPart, useWhyNot } from "../../../fleet/context";
import { defaultRobot } from "../../../fleet/names";
import { CommandErrorAlert } from "../../../ui/errors";
import { ReasonButton } from "../../../ui/ReasonButton";
import { useCommand } from "../../../ui/requests";
import { createMission } from "../requests";
import { type Taker, TakerField } from "../TakerField";
import { ArgumentFields } from "./ArgumentFields";
import { argumentsOf, missingIn, type NamedTemplate } from "./templates";

/** Asks for the parameters of a template and for who takes it, and queues a mission. */
export function RunTemplate({ template, onCancel }: { template: NamedTemplate; onCancel: () => void }) {
  const { http } = useFleet();
  const navigate = useNavigate();
  const reason = useWhyNot("POST /missions");
  const configured = useFleetPart("robots", defaultRobot);
  const [chosen, choose] = useState<Taker | null>(null);
  const [typed, type] = useState<Record<string, string>>({});
  const [tried, setTried] = useState(false);
  const [by, setBy] = useState(ownName);
  const { robot, group } = chosen ?? { robot: configured, group: null };
  const start = useCommand((body: string) => createMission(http, group === null ? robot : null, body));
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (reason !== null || start.isPending || missingIn(template, typed).length > 0) return;
    setOwnName(by.trim());
    const body = { template: template.id, arguments: argumentsOf(template, typed), by: by.trim() || null };
    start.mutate(JSON.stringify(group === null ? body : { ...body, group }), {
      onSuccess: () => navigate("/ui/missions"),
    });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <TakerField robot={robot} group={group} onTaker={choose} />
        {Object.keys(template.parameters).length === 0 ? (
          <Text size="sm" c="dimmed">
            It has no parameters.
          </Text>
        ) : (
          <ArgumentFields template={template} typed={typed} tried={tried} onType={type} />
        )}
        <NameInput value={by} description="Shown with the mission." onChange={setBy} />
        <CommandErrorAlert command="Starting the mission" error={start.error} onClose={start.reset} />
        <Group justify="flex-end" gap="sm">
          <Button variant="default" onClick={onCancel}>
            Cancel
          </Button>
          <ReasonButton type="submit" reason={reason} loading={start.isPending}>
            Start mission
          </ReasonButton>
        </Group>
      </Stack>
    </form>
  );
}
