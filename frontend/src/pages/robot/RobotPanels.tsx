import { Skeleton, Stack, Tabs } from "@mantine/core";
import { memo, Suspense } from "react";
import { BatteryCard, BatteryPlotsCard } from "../../battery/BatteryCard";
import { DockingCard } from "../../docking/DockingCard";
import { DEVELOPER, OPERATE } from "../../fleet/path";
import { GoalsCard } from "../../goals/GoalsCard";
import { SceneCard } from "../../scene/SceneCard";
import { useTopicPart } from "../../store/context";
import { Guarded } from "../../ui/Guarded";
import { lazyPart } from "../../ui/lazyPart";
import { Answers } from "./Answers";
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
  if (connecting) return <PanelsSkeleton />;
  return (
    <>
      <Answers />
      <Tabs.Panel value={OPERATE}>
        <Stack gap="md">
          <div className={classes.grid}>
            <DockingCard />
            <SceneCard />
          </div>
          <BatteryCard />
          <BatteryPlotsCard />
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
