import { Skeleton, Stack } from "@mantine/core";
import { memo } from "react";
import { BatteryCard } from "../battery/BatteryCard";
import { BatteryPlotsCard } from "../battery/BatteryPlotsCard";
import { PublisherCard } from "../battery/PublisherCard";
import { DockingCard } from "../docking/DockingCard";
import { GoalsCard } from "../goals/GoalsCard";
import { SceneCard } from "../scene/SceneCard";
import { SimulatorCard } from "../simulator/SimulatorCard";
import { useTopicPart } from "../store/context";
import { Answers } from "./Answers";
import { CurlCard } from "./CurlCard";
import classes from "./robot.module.css";

/** Everything about one robot; inside of its RobotScope. Each panel reads for itself what it shows. */
export const RobotPanels = memo(function RobotPanels() {
  // The snapshot fills most panels: shown before it, they would change their heights at once.
  const connecting = useTopicPart("connection", ({ phase }) => phase === "connecting");
  if (connecting) return <PanelsSkeleton />;
  return (
    <>
      <Answers />
      <div className={classes.grid}>
        <DockingCard />
        <div className={classes.column}>
          <SceneCard />
          <SimulatorCard />
        </div>
        <BatteryCard />
      </div>
      <BatteryPlotsCard />
      <PublisherCard />
      <GoalsCard />
      <CurlCard />
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
