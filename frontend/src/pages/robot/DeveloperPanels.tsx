import { Stack } from "@mantine/core";
import { PublisherCard } from "../../battery/PublisherCard";
import { CalibrationCard } from "../../docking/CalibrationCard";
import { SimulatorCard } from "../../simulator/SimulatorCard";
import { CurlCard } from "./CurlCard";

/** What is needed to develop and to try out: a simulated robot's controls, calibration, battery states by hand, command lines. */
export default function DeveloperPanels() {
  return (
    <Stack gap="md">
      <SimulatorCard />
      <CalibrationCard />
      <PublisherCard />
      <CurlCard />
    </Stack>
  );
}
