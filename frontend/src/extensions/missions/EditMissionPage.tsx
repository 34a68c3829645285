import { Alert, Anchor, Skeleton, Stack } from "@mantine/core";
import { useState } from "react";
import { Link, useParams } from "react-router";
import { useFleet, useNaming } from "../../fleet/context";
import { Trouble } from "../../ui/errors";
import { PageTitle } from "../../ui/Section";
import type { Draft } from "./draft";
import { useFreshMissions } from "./freshMissions";
import { draftOf } from "./fromMission";
import { missionPath } from "./MissionCard";
import { MissionForm } from "./MissionForm";
import { useMission } from "./missions";
import classes from "./missions.module.css";
import { hasBegun, hasEnded } from "./queue";
import type { Mission } from "./requests";
import { missionName, takerWords } from "./words";

/** Where a mission is changed that has not begun. */
export default function EditMissionPage() {
  const { missionId = "" } = useParams();
  useFreshMissions();
  const { data: mission, error, refetch } = useMission(missionId);
  return (
    <Stack gap="md" className={classes.form ?? ""}>
      <div>
        <Anchor component={Link} to={missionPath({ mission_id: missionId })} size="sm">
          {mission === undefined ? "The mission" : missionName(mission)}
        </Anchor>
        <PageTitle title="Edit mission" />
      </div>
      <Trouble what="The mission could not be loaded" error={error} onRetry={() => void refetch()} />
      {mission === undefined ? (
        error === null && <Skeleton height={240} role="status" aria-label="The form is loading" />
      ) : (
        <Form key={missionId} mission={mission} />
      )}
    </Stack>
  );
}

/** @param mission As it is now; the form keeps what it was filled with. */
function Form({ mission }: { mission: Mission }) {
  const { store } = useFleet();
  const naming = useNaming();
  const filled = (from: Mission) => ({ base: from, draft: draftOf(from, store.gatewayNow()) });
  const [{ base, draft }, set] = useState(() => filled(mission));
  const change = (edit: (before: Draft) => Draft) =>
    set((before) => ({ ...before, draft: edit(before.draft) }));
  return (
    <>
      {hasBegun(mission) && (
        <Alert
          color="orange"
          role="alert"
          title={hasEnded(mission) ? "It has ended" : "It has begun meanwhile"}
        >
          A mission that has begun is not changed any more.{" "}
          <Anchor component={Link} to={missionPath(mission)} inherit underline="always">
            See how it goes
          </Anchor>
        </Alert>
      )}
      <p className={classes.taker}>For {takerWords(mission, naming)}</p>
      <MissionForm
        draft={draft}
        onChange={change}
        edited={{ base, newest: mission, onShow: (newest) => set(filled(newest)) }}
      />
    </>
  );
}
