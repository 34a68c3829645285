import { Anchor, Badge, Group, Paper, Stack, Switch, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useId } from "react";
import { Link } from "react-router";
import { ownName } from "../../access/who";
import { useNaming, useWhyNot } from "../../fleet/context";
import { robotPath } from "../../fleet/names";
import { robotsWords } from "../../fleet/robotChoice";
import { poseWords } from "../../scene/poseDraft";
import { RemovalDialog } from "../../ui/Dialog";
import { CommandErrorAlert } from "../../ui/errors";
import { ENTRY_BUTTON, ReasonButton } from "../../ui/ReasonButton";
import { Time } from "../../ui/Time";
import { useDockCommands } from "./docks";
import type { DockReport, SharedDock } from "./requests";
import { canBeCleared, holderWords, STATES } from "./words";

/** A shared dock: who has it, who waits, and what a person can say of it. */
export function DockCard({ dock, onEdit }: { dock: SharedDock; onEdit: () => void }) {
  const naming = useNaming();
  const titleId = useId();
  const mayChange = useWhyNot("PUT /shared-docks/{dock_id}");
  const mayReport = useWhyNot("POST /shared-docks/{dock_id}/report");
  const { remove, report } = useDockCommands();
  const [removing, dialog] = useDisclosure(false);
  const say = (body: DockReport) =>
    report.mutate({ id: dock.dock_id, body: { ...body, by: ownName().trim() || null } });
  const { words, color } = STATES[dock.state];
  return (
    <Paper component="li" withBorder radius="md" p={{ base: "md", sm: "lg" }} aria-labelledby={titleId}>
      <Stack gap="sm">
        <Group justify="space-between" align="start">
          <Group gap="sm">
            <Text fw={600} id={titleId} style={{ overflowWrap: "anywhere" }}>
              {dock.dock_id}
            </Text>
            <Badge variant="outline" color={color}>
              {words}
            </Badge>
          </Group>
          <Switch
            label="Out of order"
            checked={dock.out_of_order_at !== null}
            disabled={mayReport !== null || report.isPending}
            title={mayReport ?? undefined}
            onChange={(event) => say({ out_of_order: event.currentTarget.checked })}
          />
        </Group>
        <Stack gap={2}>
          <Text size="sm">
            {holderWords(dock, naming)}
            {dock.since_at !== null && (
              <>
                {" (since "}
                <Time value={dock.since_at} />)
              </>
            )}{" "}
            {dock.robot !== null && (
              <Anchor component={Link} to={robotPath(dock.robot)} size="sm" underline="always">
                See the robot
              </Anchor>
            )}
          </Text>
          {dock.waiting.length > 0 && (
            <Text size="sm">
              Waiting, in this order: {dock.waiting.map(({ robot }) => naming.nameOf(robot)).join(", ")}.
            </Text>
          )}
          <Text size="sm" c="dimmed">
            {robotsWords(dock.robots, naming)}
          </Text>
          {dock.pose != null && (
            <Text size="sm" c="dimmed">
              At {poseWords(dock.pose)}
              {dock.type != null && `, of the type ${dock.type}`}
            </Text>
          )}
          {dock.waiting_places.length > 0 && (
            <Text size="sm" c="dimmed">
              Robots wait at {dock.waiting_places.map(poseWords).join("; ")}
            </Text>
          )}
        </Stack>
        <Group gap="xs">
          {canBeCleared(dock) ? (
            <ReasonButton
              {...ENTRY_BUTTON}
              reason={mayReport}
              aria-label={`Nobody stands at ${dock.dock_id}`}
              onClick={() => say({ occupied_by: "nobody" })}
            >
              Nobody stands here
            </ReasonButton>
          ) : (
            dock.state === "free" && (
              <ReasonButton
                {...ENTRY_BUTTON}
                reason={mayReport}
                aria-label={`A robot without a gateway stands at ${dock.dock_id}`}
                onClick={() => say({ occupied_by: "unknown" })}
              >
                Something stands here
              </ReasonButton>
            )
          )}
          <ReasonButton
            {...ENTRY_BUTTON}
            reason={mayChange}
            aria-label={`Edit ${dock.dock_id}`}
            onClick={onEdit}
          >
            Edit
          </ReasonButton>
          <ReasonButton
            {...ENTRY_BUTTON}
            reason={mayChange}
            aria-label={`Remove ${dock.dock_id}`}
            onClick={dialog.open}
          >
            Remove
          </ReasonButton>
        </Group>
        <CommandErrorAlert command="The report" error={report.error} onClose={report.reset} />
      </Stack>
      <RemovalDialog
        title={`Stop sharing ${dock.dock_id}?`}
        opened={removing}
        onClose={dialog.close}
        remove={remove}
        onRemove={() => remove.mutate(dock)}
      >
        <Text size="sm">Nothing is reserved there any more: several robots may drive to it at once.</Text>
      </RemovalDialog>
    </Paper>
  );
}
