import type { Robot } from "@dock-gateway/client";
import { Anchor, Skeleton, Stack } from "@mantine/core";
import { useState } from "react";
import { Link, useSearchParams } from "react-router";
import { useFleet, useFleetLive, useFleetPart } from "../../fleet/context";
import { defaultRobot, inOrder } from "../../fleet/names";
import { isThere } from "../../fleet/words";
import { Trouble } from "../../ui/errors";
import { PageTitle } from "../../ui/Section";
import { type Draft, exampleMission, newMission } from "./draft";
import { useFreshMissions } from "./freshMissions";
import { draftOf } from "./fromMission";
import { MissionForm } from "./MissionForm";
import { useMission } from "./missions";
import classes from "./missions.module.css";

/** Where a mission is put together: empty, from an example (`?example`), or from one that has ended (`?from=`). */
export default function NewMissionPage() {
  useFreshMissions();
  const [query] = useSearchParams();
  const { store } = useFleet();
  const from = query.get("from");
  const { data: first, error, refetch } = useMission(from);
  const known = useFleetPart("robots", (robots) => robots.size > 0);
  const live = useFleetLive();
  const [draft, setDraft] = useState<Draft | null>(null);
  const robot = useFleetPart("robots", (robots) => query.get("robot") ?? firstRobot(robots));
  if (draft === null && (known || live)) {
    const now = store.gatewayNow();
    if (from === null) setDraft(query.has("example") ? exampleMission(robot, now) : newMission(robot));
    else if (first !== undefined) setDraft(draftOf(first, now, robot));
  }
  return (
    <Stack gap="md" className={classes.form ?? ""}>
      <div>
        <Anchor component={Link} to="/ui/missions" size="sm">
          All missions
        </Anchor>
        <PageTitle title="New mission" help="extensions/missions#a-tour" />
      </div>
      <Trouble what="The mission could not be loaded" error={error} onRetry={() => void refetch()} />
      {draft === null ? (
        error === null && <Skeleton height={240} role="status" aria-label="The form is loading" />
      ) : (
        <MissionForm draft={draft} onChange={(change) => setDraft((now) => now && change(now))} />
      )}
    </Stack>
  );
}

/** The configured robot if it is there, else another one that is. */
function firstRobot(robots: ReadonlyMap<string, Robot>): string {
  const configured = defaultRobot(robots);
  const there = [...robots.values()].filter(isThere).sort(inOrder);
  return (there.find(({ name }) => name === configured) ?? there[0])?.name ?? configured;
}
