import { Skeleton } from "@mantine/core";
import { Suspense, useMemo } from "react";
import { useFleetPart } from "../../fleet/context";
import { byName } from "../../fleet/names";
import { isThere } from "../../fleet/words";
import { Guarded } from "../../ui/Guarded";
import { lazyPart } from "../../ui/lazyPart";
import classes from "./robot.module.css";

/** Comes where there are several robots. */
const RobotSelect = lazyPart(() => import("./RobotSelect"));

/** Goes to another robot of the fleet. Nothing where there is no other one. */
export function RobotSwitcher({ robot }: { robot: string }) {
  const names = useFleetPart("robots", (robots) =>
    [...robots.values()].flatMap((each) => (isThere(each) ? [each.name] : [])).join("\n"),
  );
  const others = useMemo(
    () =>
      names
        .split("\n")
        .filter((name) => name !== "" && name !== robot)
        .sort(byName),
    [names, robot],
  );
  if (others.length === 0) return null;
  return (
    <div className={classes.switcher}>
      <Guarded of={robot}>
        <Suspense fallback={<Skeleton height={36} />}>
          <RobotSelect others={others} />
        </Suspense>
      </Guarded>
    </div>
  );
}
