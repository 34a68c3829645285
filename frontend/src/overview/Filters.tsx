import { TextInput } from "@mantine/core";
import { useMemo } from "react";
import type { Robot } from "../fleet/types";
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
      <TextInput
        type="search"
        className={classes.search}
        aria-label="Search robots by name"
        placeholder="Name, such as robot1"
        value={view.text}
        onChange={(event) => onChange({ text: event.currentTarget.value })}
      />
    </div>
  );
}
