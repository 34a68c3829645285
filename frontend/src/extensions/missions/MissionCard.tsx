import { Alert, Anchor, Badge, Button, Group, Stack, Text } from "@mantine/core";
import { useId } from "react";
import { Link } from "react-router";
import { useForbidden } from "../../api/session";
import { useAtTime } from "../../clock/clock";
import { NOT_CONNECTED, useFleetLive, useFleetPart } from "../../fleet/context";
import { goalPath } from "../../fleet/names";
import { CommandErrorAlert } from "../../ui/errors";
import { ENTRY_BUTTON, ReasonButton } from "../../ui/ReasonButton";
import { Time } from "../../ui/Time";
import { MissionSteps } from "./MissionSteps";
import { useMissionCommand } from "./missions";
import classes from "./missions.module.css";
import { hasBegun, hasEnded } from "./queue";
import type { Mission, MissionStatus, Verb } from "./requests";
import {
  breakWords,
  errorDetail,
  errorWords,
  groupWaitWords,
  holdOf,
  limitWords,
  missionName,
  nowWords,
  STATUSES,
  stepPlace,
  stepWords,
  tookWords,
} from "./words";

export function missionPath({ mission_id }: Pick<Mission, "mission_id">): string {
  return `/ui/missions/${mission_id}`;
}

/** Where the form is that starts a mission once more. */
export function againPath({ mission_id }: Pick<Mission, "mission_id">): string {
  return `/ui/missions/new?from=${mission_id}`;
}

/** Leads to the form that changes a mission; nothing once it has begun, or for those who may not. */
export function EditLink({ mission }: { mission: Mission }) {
  const forbidden = useForbidden("PUT /missions/{mission_id}");
  if (forbidden !== null || hasBegun(mission)) return null;
  return (
    <Button
      component={Link}
      to={`${missionPath(mission)}/edit`}
      {...ENTRY_BUTTON}
      aria-label={`Edit: ${missionName(mission)}`}
    >
      Edit
    </Button>
  );
}

export function MissionBadge({ status }: { status: MissionStatus }) {
  const { words, color } = STATUSES[status];
  return (
    <Badge variant="outline" color={color} className={classes.badge ?? ""}>
      {words}
    </Badge>
  );
}

interface MissionCardProps {
  mission: Mission;
  /** Whether its name leads to its page. */
  linked?: boolean;
}

/** A mission that has begun: how far it is, what it waits for, and what can be done about it. */
export function MissionCard({ mission, linked = false }: MissionCardProps) {
  const titleId = useId();
  const command = useMissionCommand();
  const name = missionName(mission);
  return (
    <article className={classes.card} aria-labelledby={titleId}>
      <div className={classes.head}>
        <div className={classes.words}>
          <Group gap="xs">
            <Text fw={600} id={titleId} className={classes.name}>
              {linked ? (
                <Anchor component={Link} to={missionPath(mission)} inherit>
                  {name}
                </Anchor>
              ) : (
                name
              )}
            </Text>
            <span role="status">
              <MissionBadge status={mission.status} />
            </span>
          </Group>
          <Facts mission={mission} />
        </div>
        {mission.status !== "held" && <Commands mission={mission} command={command} />}
      </div>
      <Situation mission={mission} command={command} />
      <CommandErrorAlert command="The command" error={command.error} onClose={command.reset} />
      <MissionSteps mission={mission} />
    </article>
  );
}

/** When it began and for how long it has been on its way, and who asked for it. */
function Facts({ mission }: { mission: Mission }) {
  const { created_by, created_at, started_at, finished_at, battery } = mission;
  const took = useAtTime((now) => tookWords(mission, now));
  return (
    <Text size="sm" c="dimmed" component="div" className={`tabular ${classes.facts}`}>
      <span>
        {started_at === null ? "Queued " : "Began "}
        <Time value={started_at ?? created_at} />
        {created_by !== null && ` by ${created_by}`}
      </span>
      {finished_at !== null && (
        <span>
          Ended <Time value={finished_at} />
        </span>
      )}
      {battery !== null && <span>{limitWords(battery)}</span>}
      {took !== "" && <span>{finished_at === null ? `${took} so far` : `took ${took}`}</span>}
    </Text>
  );
}

type Command = ReturnType<typeof useMissionCommand>;

/** What it waits for, why it is held, or why it has failed. */
function Situation({ mission, command }: { mission: Mission; command: Command }) {
  const { status, error, pausing } = mission;
  const hold = holdOf(mission);
  const stopped = useStopped(mission);
  if (status === "failed" && error !== null)
    return (
      <Text size="sm" c="var(--mantine-color-error)">
        {sentenceOfFailure(mission)}
      </Text>
    );
  if (hasEnded(mission)) return null;
  if (hold !== null)
    return (
      <Alert color="orange" title={hold.title} role="status">
        <Stack gap="xs">
          <Text size="sm">
            {stopped && "Release the stop first. "}
            {hold.words}
          </Text>
          <Recharge mission={mission} />
          <Commands mission={mission} command={command} />
        </Stack>
      </Alert>
    );
  return (
    <>
      <Now mission={mission} />
      {pausing && (
        <Text size="sm" fw={600} role="status">
          It pauses after this step.
        </Text>
      )}
    </>
  );
}

function sentenceOfFailure(mission: Mission): string {
  const { steps, step, error } = mission;
  const failed = steps[step];
  const where = failed === undefined ? "" : `${stepPlace(mission)}, ${stepWords(failed)}: `;
  return error === null ? "" : `${where}${where === "" ? errorWords(error) : lower(errorWords(error))}.`;
}

function lower(text: string): string {
  return text.charAt(0).toLowerCase() + text.slice(1);
}

/** The present step, what it waits for, and since when. */
function Now({ mission }: { mission: Mission }) {
  const charge = useFleetPart("robots", (robots) => {
    const battery = robots.get(mission.robot ?? "")?.battery;
    return battery === undefined || battery.stale ? null : battery.percentage;
  });
  const words = useAtTime((now) => nowWords(mission, charge, now));
  const step = mission.steps[mission.step];
  if (mission.robot === null) return <Text size="sm">{groupWaitWords(mission)}</Text>;
  if (mission.started_at === null || step === undefined) return null;
  if (mission.recharge !== null)
    return (
      <>
        <Text size="sm" className="tabular">
          <strong>{breakWords(mission)}</strong>
          {words !== "" && `. ${words}`}{" "}
          <Text span size="sm" c="dimmed">
            (since <Time value={mission.recharge.started_at} />)
          </Text>
        </Text>
        <Recharge mission={mission} />
        <Text size="sm" c="dimmed">
          Then {stepPlace(mission)}: {stepWords(step)}
        </Text>
      </>
    );
  return (
    <Text size="sm" className="tabular">
      <strong>
        {stepPlace(mission)}: {stepWords(step)}
      </strong>
      {words !== "" && `. ${words}`}
      {step.status === "running" && step.started_at !== null && (
        <Text span size="sm" c="dimmed">
          {" "}
          (since <Time value={step.started_at} />)
        </Text>
      )}
    </Text>
  );
}

/** The goal of a break for the battery, and why its last try has failed. */
function Recharge({ mission: { recharge, robot } }: { mission: Mission }) {
  if (recharge === null || (recharge.goal_id === null && recharge.error === null)) return null;
  const detail = recharge.error === null ? null : errorDetail(recharge.error);
  return (
    <Text size="sm" component="div" className={classes.facts}>
      {recharge.goal_id !== null && (
        <Anchor component={Link} to={goalPath(recharge.goal_id, robot)} size="sm" underline="always">
          Goal {recharge.goal_id.slice(0, 8)}
        </Anchor>
      )}
      {recharge.error !== null && (
        <span>
          Last try: {errorWords(recharge.error)}
          {detail !== null && `. ${detail}`}
        </span>
      )}
    </Text>
  );
}

/** Whether a stop holds for its robot. */
function useStopped({ robot }: Mission): boolean {
  return useFleetPart("robots", (robots) => robots.get(robot ?? "")?.stop.latched === true);
}

interface CommandsProps {
  mission: Mission;
  command: Command;
}

/** What can be done about a mission; nothing for those who may not. */
export function Commands({ mission, command }: CommandsProps) {
  const forbidden = useForbidden("POST /missions/{mission_id}/cancel");
  const live = useFleetLive();
  const stopped = useStopped(mission);
  if (forbidden !== null || hasEnded(mission)) return null;
  const { status, held_for, started_at, pausing, robot, waits_for } = mission;
  const name = missionName(mission);
  const waiting = command.isPending ? "The gateway has not answered yet." : null;
  const reason = live ? waiting : NOT_CONNECTED;
  const held = reason ?? (stopped ? "The robot is stopped. Release the stop first." : null);
  const give = (verb: Verb) => () => command.mutate({ id: mission.mission_id, verb });
  const button = (verb: Verb, words: string, why: string | null, primary = false) => (
    <ReasonButton
      {...ENTRY_BUTTON}
      {...(primary && { variant: "filled" })}
      reason={why}
      aria-label={`${words}: ${name}`}
      onClick={give(verb)}
    >
      {words}
    </ReasonButton>
  );
  const mayBegin = robot === null && waits_for === "continue" && held_for === null;
  const canceling = status === "canceling" ? "It is being canceled." : null;
  return (
    <Group gap="xs" className={classes.commands ?? ""}>
      {(held_for !== null || mayBegin) && button("continue", "Continue", held, true)}
      {held_for !== null && started_at !== null && button("skip", "Skip step", held)}
      {held_for === null &&
        button("pause", "Pause", reason ?? canceling ?? (pausing ? "It pauses after this step." : null))}
      {button("cancel", "Cancel", reason ?? canceling)}
    </Group>
  );
}
