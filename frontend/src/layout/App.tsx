import { Container, Stack } from "@mantine/core";
import { BatteryCard } from "../battery/BatteryCard";
import { PublisherCard } from "../battery/PublisherCard";
import { DockingCard } from "../docking/DockingCard";
import { GoalsCard } from "../goals/GoalsCard";
import { ConnectionBanner } from "./ConnectionBanner";
import { CurlCard } from "./CurlCard";
import { Header } from "./Header";
import classes from "./layout.module.css";

export function App() {
  return (
    <>
      <Header />
      <Container component="main" size="xl" py="md">
        <Stack gap="md">
          <ConnectionBanner />
          <div className={classes.grid}>
            <DockingCard />
            <BatteryCard />
            <PublisherCard />
            <GoalsCard />
          </div>
          <CurlCard />
        </Stack>
      </Container>
    </>
  );
}
