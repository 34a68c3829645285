import { memo } from "react";
import { BatteryCard } from "../battery/BatteryCard";
import { BatteryPlotsCard } from "../battery/BatteryPlotsCard";
import { PublisherCard } from "../battery/PublisherCard";
import { DockingCard } from "../docking/DockingCard";
import { GoalsCard } from "../goals/GoalsCard";
import { SceneCard } from "../scene/SceneCard";
import { SimulatorCard } from "../simulator/SimulatorCard";
import { Answers } from "./Answers";
import { CurlCard } from "./CurlCard";
import classes from "./robot.module.css";

/** Everything about one robot; inside of its RobotScope. Each panel reads for itself what it shows. */
export const RobotPanels = memo(function RobotPanels() {
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
