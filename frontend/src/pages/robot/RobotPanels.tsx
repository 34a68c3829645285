import { isTerminal } from "@dock-gateway/client";
import { Skeleton, Stack, Tabs } from "@mantine/core";
import { memo, Suspense, useEffect, useState } from "react";
import { createGoalsApi } from "../../api/goals";
import { BatteryCard, BatteryPlotsCard } from "../../battery/BatteryCard";
import { DockingCard } from "../../docking/DockingCard";
import { Parts } from "../../extension/context";
import { ForeignCards } from "../../extension/ForeignCards";
import { useFleet, useFleetPart } from "../../fleet/context";
import { DEVELOPER, defaultRobot, OPERATE } from "../../fleet/names";
import { GoalsCard } from "../../goals/GoalsTable";
import { SceneCard } from "../../scene/SceneCard";
import { useServices, useTopicPart } from "../../store/context";
import { Guarded } from "../../ui/Guarded";
import { lazyPart } from "../../ui/lazyPart";
import classes from "./robot.module.css";

/** Operators do without. */
const DeveloperPanels = lazyPart(() => import("./DeveloperPanels"));

interface RobotPanelsProps {
  /** Whether the developers' panels were asked for: they are loaded then, and stay as they are behind the other tab. */
  developer: boolean;
}

/** Everything about one robot; inside of its RobotScope and Tabs. Each panel reads for itself what it shows. */
export const RobotPanels = memo(function RobotPanels({ developer }: RobotPanelsProps) {
  // The snapshot fills most panels: shown before it, they would change their heights at once.
  const connecting = useTopicPart("connection", ({ phase }) => phase === "connecting");
  const { robot } = useServices();
  const name = useFleetPart("robots", (robots) => robot ?? defaultRobot(robots));
  if (connecting) return <PanelsSkeleton />;
  return (
    <>
      <Answers />
      <Tabs.Panel value={OPERATE}>
        <Stack gap="md">
          <div className={classes.grid}>
            <div className={classes.column}>
              <DockingCard />
              <Parts at="robotColumn" robot={name} />
            </div>
            <SceneCard />
          </div>
          <BatteryCard />
          <BatteryPlotsCard />
          <Parts at="robotPanels" robot={name} />
          <ForeignCards robot={name} />
          <GoalsCard />
        </Stack>
      </Tabs.Panel>
      <Tabs.Panel value={DEVELOPER}>
        {developer && (
          <Guarded of={DEVELOPER}>
            <Suspense fallback={<PanelsSkeleton />}>
              <DeveloperPanels />
            </Suspense>
          </Guarded>
        )}
      </Tabs.Panel>
    </>
  );
});

function PanelsSkeleton() {
  return (
    <Stack role="group" aria-busy="true" aria-label="The robot's state is loading">
      <Skeleton height="100vh" />
    </Stack>
  );
}

/** Asks once for the stored poses of a goal that ran already when the page was opened. Shows nothing. */
function Answers() {
  const { http } = useFleet();
  const { scene, store } = useServices();
  const [goalId] = useState(() => store.get("courses").find(({ status }) => !isTerminal(status))?.goal_id);
  useEffect(() => {
    if (goalId !== undefined) return ask(createGoalsApi(http).poses(goalId), (poses) => scene.recall(poses));
  }, [http, scene, goalId]);

  return null;
}

/** Hands on the answer unless the returned function was called before it came. */
function ask<Answer>(answer: Promise<Answer>, take: (answer: Answer) => void): () => void {
  let wanted = true;
  // Without an answer it is as before; what is wrong with the connection is said at the top.
  answer.then((value) => wanted && take(value)).catch(() => {});
  return () => {
    wanted = false;
  };
}
