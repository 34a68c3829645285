import { NativeSelect, SegmentedControl } from "@mantine/core";
import { useFleet, useRobotOptions } from "../fleet/context";
import { GroupSelect } from "../fleet/RobotFields";
import { TagSelect } from "../goals/TagSelect";
import { TimeRangeField } from "../ui/TimeRangeField";
import classes from "./statistics.module.css";
import { GROUPINGS, type Grouping, type View } from "./view";

interface ControlsProps {
  view: View;
  onChange: (view: View) => void;
}

const BY = Object.entries(GROUPINGS).map(([value, label]) => ({ value, label }));

/** Which goals, and what they are grouped by. */
export function Controls({ view, onChange }: ControlsProps) {
  const { store } = useFleet();
  const change = (part: Partial<View>) => onChange({ ...view, ...part });
  const robots = useRobotOptions(view.robot);
  return (
    <section aria-label="Choose goals" className={classes.controls}>
      <TimeRangeField
        value={view.time}
        onChange={(time) => change({ time })}
        now={() => store.gatewayNow()}
      />
      <SegmentedControl
        aria-label="Group by"
        data={BY}
        value={view.by}
        onChange={(by) => change({ by: by as Grouping })}
      />
      <NativeSelect
        aria-label="Robot"
        value={view.robot ?? ""}
        onChange={(event) => change({ robot: event.currentTarget.value || null })}
        data={[{ value: "", label: "All robots" }, ...robots]}
      />
      <GroupSelect aria-label="Group" group={view.group} onGroup={(group) => change({ group })} />
      <TagSelect aria-label="Tag" any="All tags" chosen={view.tags} onTags={(tags) => change({ tags })} />
    </section>
  );
}
