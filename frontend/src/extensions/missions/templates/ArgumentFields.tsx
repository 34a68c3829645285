import { NativeSelect, TextInput } from "@mantine/core";
import classes from "../missions.module.css";
import { usePlaces } from "../places/places";
import type { Template } from "./requests";
import { missingIn, placesIn, textOf } from "./templates";

interface ArgumentFieldsProps {
  template: Template;
  /** What was typed, by the parameter. */
  typed: Record<string, string>;
  /** Whether somebody has tried to send it: then also what is missing is said. */
  tried: boolean;
  onType: (typed: Record<string, string>) => void;
}

/** A field for each parameter of a template. */
export function ArgumentFields({ template, typed, tried, onType }: ArgumentFieldsProps) {
  const { data: places = [] } = usePlaces();
  const driven = placesIn(template.steps);
  const missing = tried ? missingIn(template, typed) : [];
  return (
    <div className={classes.fields}>
      {Object.entries(template.parameters).map(([name, { description, default: initial }]) => {
        const field = {
          label: name,
          description: description ?? undefined,
          value: typed[name] ?? "",
          error: missing.includes(name) ? "Needs a value." : undefined,
          onChange: (event: { currentTarget: { value: string } }) =>
            onType({ ...typed, [name]: event.currentTarget.value }),
        };
        const usual = initial == null ? null : textOf(initial);
        if (!driven.has(name) || places.length === 0)
          return <TextInput key={name} {...field} placeholder={usual ?? undefined} />;
        return (
          <NativeSelect
            key={name}
            {...field}
            data={[
              { value: "", label: usual ?? "Choose a place" },
              ...places.map(({ id, name: label }) => ({ value: id, label })),
            ]}
          />
        );
      })}
    </div>
  );
}
