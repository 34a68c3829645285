import { Skeleton } from "@mantine/core";
import { Suspense } from "react";
import { lazyPart } from "../ui/lazyPart";
import { Section } from "../ui/Section";
import classes from "./BatteryPlots.module.css";

/** What draws them comes after the page, which is of use without. */
const BatteryPlots = lazyPart(() => import("./BatteryPlots"));

export function BatteryPlotsCard() {
  return (
    <Section title="Battery over time">
      <Suspense fallback={<Skeleton className={classes.waiting} />}>
        <BatteryPlots />
      </Suspense>
    </Section>
  );
}
