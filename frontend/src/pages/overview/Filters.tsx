import { TextInput } from "@mantine/core";
import { useMemo, useState } from "react";
import type { Robot } from "../../api/types";
import { GroupSelect } from "../../fleet/RobotFields";
import { type Attentions, matches, SHOW_WORDS, SHOWS, type View } from "./list";
import classes from "./overview.module.css";

interface FiltersProps {
  robots: readonly Robot[];
  attentions: Attentions;
  view: View;
  onChange: (change: Partial<View>) => void;
}

/** How many robots there are of each kind, to read at a glance; pressed, the list shows those alone. */
export function Filters({ robots, attentions, view, onChange }: FiltersProps) {
  const counts = useMemo(
    () => SHOWS.map((show) => robots.filter((robot) => matches(robot, show, attentions)).length),
    [robots, attentions],
  );
  return (
    <div className={classes.filters}>
      <fieldset className={classes.shows}>
        <legend className={classes.legend}>Show robots</legend>
        {SHOWS.map((show, index) => (
          <button
            key={show}
            type="button"
            className={classes.show}
            aria-pressed={view.show === show}
            data-none={counts[index] === 0 || undefined}
            onClick={() => onChange({ show: view.show === show ? "all" : show })}
          >
            <span className={classes.number}>{counts[index]}</span> {SHOW_WORDS[show]}
          </button>
        ))}
      </fieldset>
      <div className={classes.choices}>
        <GroupSelect
          className={classes.group ?? ""}
          aria-label="Group"
          group={view.group}
          onGroup={(group) => onChange({ group })}
        />
        <Search text={view.text} onText={(text) => onChange({ text })} />
      </div>
    </div>
  );
}

/** Shows at once what is typed; the address, which follows, may be a few letters behind. */
function Search({ text, onText }: { text: string; onText: (text: string) => void }) {
  const [typed, setTyped] = useState<string | null>(null);
  return (
    <TextInput
      type="search"
      className={classes.search ?? ""}
      aria-label="Search robots by name or group"
      placeholder="Name or group"
      value={typed ?? text}
      onChange={(event) => {
        setTyped(event.currentTarget.value);
        onText(event.currentTarget.value);
      }}
      onBlur={() => setTyped(null)}
    />
  );
}
