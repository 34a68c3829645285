import { Anchor, Switch, Text } from "@mantine/core";
import { useState } from "react";
import { Link } from "react-router";
import { ownName } from "../../../access/who";
import { EntryCard } from "../../../entries/EntryCard";
import { useNaming, useWhyNot } from "../../../fleet/context";
import { Dialog } from "../../../ui/Dialog";
import { Empty } from "../../../ui/Empty";
import { CommandErrorAlert } from "../../../ui/errors";
import { ReasonButton } from "../../../ui/ReasonButton";
import { Time } from "../../../ui/Time";
import { useZone } from "../../../ui/zone";
import { StoredPage } from "../StoredPage";
import { useStoredCommands } from "../stored";
import { useTemplates } from "../templates/templates";
import { ScheduleForm } from "./ScheduleForm";
import {
  failureWords,
  missionWords,
  type NamedSchedule,
  SCHEDULES,
  useSchedules,
  whenWords,
  withEnabled,
} from "./schedules";

/** Missions that are queued by themselves. */
export default function SchedulesPage() {
  const query = useSchedules();
  const reason = useWhyNot("PUT /schedules/{schedule_id}", query.data !== undefined);
  const templates = useTemplates();
  const [edited, setEdited] = useState<{ schedule: NamedSchedule | null } | null>(null);
  const close = () => setEdited(null);
  return (
    <>
      <StoredPage
        title="Schedules"
        what="schedules"
        button={
          <ReasonButton reason={reason} onClick={() => setEdited({ schedule: null })}>
            New schedule
          </ReasonButton>
        }
        query={query}
        empty={
          <Empty title="No schedules">
            A schedule queues a mission by itself: once, at times of day, or every so many minutes. What was
            missed while no gateway ran is made up if it was due within the last hour. One that is off does
            nothing.
          </Empty>
        }
      >
        {(schedules) =>
          schedules.map((schedule) => (
            <ScheduleCard key={schedule.id} schedule={schedule} onEdit={() => setEdited({ schedule })} />
          ))
        }
      </StoredPage>
      <Dialog
        opened={edited !== null}
        onClose={close}
        title={edited?.schedule ? `Edit ${edited.schedule.name}` : "New schedule"}
        size="xl"
      >
        {edited !== null && !templates.isPending && (
          <ScheduleForm schedule={edited.schedule} schedules={query.data ?? []} onDone={close} />
        )}
      </Dialog>
    </>
  );
}

function ScheduleCard({ schedule, onEdit }: { schedule: NamedSchedule; onEdit: () => void }) {
  const { robot, group } = schedule;
  const naming = useNaming();
  useZone();
  const reason = useWhyNot("PUT /schedules/{schedule_id}");
  const { data: templates = [] } = useTemplates();
  const { save, remove } = useStoredCommands(SCHEDULES);
  const set = (enabled: boolean) =>
    save.mutate({
      id: schedule.id,
      body: withEnabled(schedule, enabled, ownName().trim() || null),
      base: schedule,
    });
  return (
    <EntryCard
      entry={schedule}
      words={[
        whenWords(schedule),
        `${missionWords(schedule, templates)} for ${robot === null ? `any of ${group}` : naming.fullNameOf(robot)}`,
      ]}
      control={
        <Switch
          label={schedule.enabled ? "On" : "Off"}
          aria-label={`${schedule.name} is on`}
          checked={schedule.enabled}
          disabled={reason !== null || save.isPending}
          title={reason ?? undefined}
          onChange={(event) => set(event.currentTarget.checked)}
        />
      }
      reason={reason}
      onEdit={onEdit}
      remove={remove}
      removal="Missions that it has queued go on."
    >
      <Outcomes schedule={schedule} />
      <CommandErrorAlert command="Saving" error={save.error} onClose={save.reset} />
    </EntryCard>
  );
}

/** The next time, and what came of the last one. */
function Outcomes({ schedule: { enabled, next_at, last, ...rest } }: { schedule: NamedSchedule }) {
  const failure = failureWords({ last });
  const isAlert = failure !== null && last?.code !== "still_running";
  return (
    <div>
      <Text size="sm">
        {next_at !== null ? (
          <>
            Next <Time value={next_at} />
          </>
        ) : enabled ? (
          "No more times"
        ) : (
          "Switched off: it queues nothing"
        )}
        {rest.if_running === "queue" && ", also while its last mission has not ended"}
      </Text>
      {last !== null && (
        <Text size="sm" c={isAlert ? "var(--mantine-color-error)" : "dimmed"}>
          Last <Time value={last.due_at} />:{" "}
          {last.mission_id === null ? (
            failure
          ) : (
            <Anchor component={Link} to={`/ui/missions/${last.mission_id}`} size="sm" underline="always">
              See its mission
            </Anchor>
          )}
        </Text>
      )}
    </div>
  );
}
