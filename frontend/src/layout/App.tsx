import { Container, Stack } from "@mantine/core";
import { BatteryCard } from "../battery/BatteryCard";
import { PublisherCard } from "../battery/PublisherCard";
import { DockingCard } from "../docking/DockingCard";
import { GoalsCard } from "../goals/GoalsCard";
import { SceneCard } from "../scene/SceneCard";
import { SimulatorCard } from "../simulator/SimulatorCard";
import { StopBanner } from "../stop/StopBanner";
import { Answers } from "./Answers";
import { ConnectionBanner } from "./ConnectionBanner";
import { CurlCard } from "./CurlCard";
import { Header } from "./Header";
import classes from "./layout.module.css";

export function App() {
  return (
    <>
      <Answers />
      <Header />
      <Container component="main" size="xl" py="md">
        <Stack gap="md">
          <ConnectionBanner />
          <StopBanner />
          <div className={classes.grid}>
            <DockingCard />
            <div className={classes.column}>
              <SceneCard />
              <SimulatorCard />
              <PublisherCard />
            </div>
            <BatteryCard />
          </div>
          <GoalsCard />
          <CurlCard />
        </Stack>
      </Container>
    </>
  );
}
