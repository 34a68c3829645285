import { Skeleton } from "@mantine/core";
import { lazy, Suspense } from "react";
import { Section } from "../ui/Section";
import classes from "./BatteryPlots.module.css";

/** What draws them comes after the page, which is of use without. */
const BatteryPlots = lazy(() => import("./BatteryPlots"));

export function BatteryPlotsCard() {
  return (
    <Section title="Battery over time">
      <Suspense fallback={<Skeleton className={classes.waiting} />}>
        <BatteryPlots />
      </Suspense>
    </Section>
  );
}
