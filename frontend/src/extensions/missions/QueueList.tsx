import { Anchor, Badge, Group, Text, VisuallyHidden } from "@mantine/core";
import { useEffect, useRef, useState } from "react";
import { Link } from "react-router";
import { useForbidden } from "../../api/session";
import { useFleetLive } from "../../fleet/context";
import { CommandErrorAlert } from "../../ui/errors";
import { Time } from "../../ui/Time";
import { Tool } from "../../ui/Tool";
import { Commands, EditLink, missionPath } from "./MissionCard";
import { useMissionCommand, useMove } from "./missions";
import classes from "./missions.module.css";
import { PRIORITY } from "./queue";
import type { Mission } from "./requests";
import { DOWN, UP } from "./StepCard";
import { groupWaitWords, holdOf, missionName } from "./words";

interface QueueListProps {
  /** Whose queue it is. */
  name: string;
  /** In the order in which they begin. */
  next: readonly Mission[];
}

/** A mission that was moved, and its place before. */
interface Moved {
  id: string;
  from: number;
  by: -1 | 1;
}

/** Missions in the order in which they begin, with buttons that change it. */
export function QueueList({ name, next }: QueueListProps) {
  const forbidden = useForbidden("POST /missions/{mission_id}/move");
  const live = useFleetLive();
  const move = useMove();
  const [said, say] = useState("");
  const moved = useRef<Moved | null>(null);
  const list = useRef<HTMLOListElement>(null);

  // The button that was pressed has the focus again when its mission has its new place.
  useEffect(() => {
    if (moved.current === null) return;
    const { id, from, by } = moved.current;
    const at = next.findIndex(({ mission_id }) => mission_id === id);
    if (at === from) return;
    moved.current = null;
    if (document.activeElement !== document.body && !list.current?.contains(document.activeElement)) return;
    const row = list.current?.querySelector<HTMLElement>(`[data-mission="${id}"]`);
    const button = row?.querySelector<HTMLElement>(`[data-move="${by === -1 ? "up" : "down"}"]:enabled`);
    (button ?? row)?.focus();
  });

  const go = (from: number, by: -1 | 1) => {
    const [mission, other] = [next[from], next[from + by]];
    if (mission === undefined || other === undefined || !live || move.isPending) return;
    const id = mission.mission_id;
    moved.current = { id, from, by };
    const place = by === -1 ? { before: other.mission_id } : { after: other.mission_id };
    move.mutate(
      { id, place },
      {
        onSuccess: () => say(`${missionName(mission)} is now number ${from + by + 1} of ${next.length}`),
        onError: () => {
          moved.current = null;
        },
      },
    );
  };
  return (
    <>
      <ol className={classes.queue} aria-label={`Next for ${name}`} ref={list}>
        {next.map((mission, index) => (
          <Queued
            key={mission.mission_id}
            mission={mission}
            place={index + 1}
            count={next.length}
            onMove={forbidden === null && next.length > 1 ? (by) => go(index, by) : null}
          />
        ))}
      </ol>
      <CommandErrorAlert command="Moving" error={move.error} onClose={move.reset} />
      <VisuallyHidden aria-live="polite">{said}</VisuallyHidden>
    </>
  );
}

interface QueuedProps {
  mission: Mission;
  place: number;
  count: number;
  /** Null where it cannot be moved. */
  onMove: ((by: -1 | 1) => void) | null;
}

/** A mission that waits for its turn. */
function Queued({ mission, place, count, onMove }: QueuedProps) {
  const command = useMissionCommand();
  const hold = holdOf(mission);
  const name = missionName(mission);
  const steps = mission.steps.length === 1 ? "One step" : `${mission.steps.length} steps`;
  return (
    <li className={classes.queued} data-mission={mission.mission_id} tabIndex={-1}>
      <span className={`tabular ${classes.place}`} aria-hidden="true">
        {place}
      </span>
      <div className={classes.words}>
        <Group gap="xs">
          <Anchor component={Link} to={missionPath(mission)} size="sm" fw={600}>
            {name}
          </Anchor>
          {hold !== null && (
            <Badge variant="outline" color="orange" className={classes.badge ?? ""}>
              {hold.title}
            </Badge>
          )}
        </Group>
        <Text size="sm" c="dimmed" component="div" className={classes.facts}>
          <span>{steps}</span>
          {mission.priority !== PRIORITY && <span>Priority {mission.priority}</span>}
          <span>
            Queued <Time value={mission.created_at} />
            {mission.created_by !== null && ` by ${mission.created_by}`}
          </span>
        </Text>
        {hold !== null && <Text size="sm">{hold.words}</Text>}
        {hold === null && mission.robot === null && <Text size="sm">{groupWaitWords(mission)}</Text>}
        <CommandErrorAlert command="The command" error={command.error} onClose={command.reset} />
      </div>
      <Group gap="xs" className={classes.commands ?? ""}>
        {onMove !== null && (
          <Group gap={4} wrap="nowrap">
            <Tool
              name={`Move ${name} up`}
              path={UP}
              data-move="up"
              disabled={place === 1}
              onClick={() => onMove(-1)}
            />
            <Tool
              name={`Move ${name} down`}
              path={DOWN}
              data-move="down"
              disabled={place === count}
              onClick={() => onMove(1)}
            />
          </Group>
        )}
        <EditLink mission={mission} />
        <Commands mission={mission} command={command} />
      </Group>
    </li>
  );
}
