import { Button, Group, Text } from "@mantine/core";
import { isArray, type Json } from "../../api/jsonSchema";
import { emptyOf } from "../form/read";
import type { ListShape } from "../form/shapes";
import type { Value } from "../form/values";
import { lengthWords } from "../form/write";
import { type InputProps, useField } from "./context";
import classes from "./fields.module.css";
import { FieldInput } from "./MessageFields";

interface ListFieldProps extends InputProps<readonly Value[]> {
  shape: ListShape;
  sent: Json | undefined;
}

/** An array, item by item: with as many as there may be. */
export function ListField({ path, label, description, value, shape, sent }: ListFieldProps) {
  const { ref: add, error, set } = useField<HTMLButtonElement>(path, false);
  const fixed = shape.low === shape.high;
  const full = value.length >= shape.high;
  const item = { name: "", shape: shape.item, description: null, unit: null, initial: undefined };
  return (
    <fieldset className={classes.list}>
      <legend>{label}</legend>
      <Text size="sm" c="dimmed" className={classes.description}>
        {description}
        {description !== null && <br />}
        {value.length} of {lengthWords(shape, "item") || "any number of items"}
      </Text>
      {value.map((each, index) => (
        // biome-ignore lint/suspicious/noArrayIndexKey: an item is known by its place alone
        <div key={index} className={classes.item}>
          <div className={classes.input}>
            <FieldInput
              field={item}
              label={`${label} ${index + 1}`}
              path={[...path, index]}
              value={each}
              sent={isArray(sent) ? sent[index] : undefined}
            />
          </div>
          {!fixed && (
            <Button
              variant="default"
              size="compact-sm"
              disabled={value.length <= shape.low}
              aria-label={`Remove ${label} ${index + 1}`}
              onClick={() => {
                set(value.filter((_, at) => at !== index));
                add.current?.focus();
              }}
            >
              Remove
            </Button>
          )}
        </div>
      ))}
      {!fixed && (
        <Group gap="sm">
          <Button
            ref={add}
            variant="default"
            size="compact-sm"
            disabled={full}
            onClick={() => set([...value, emptyOf(shape.item)])}
          >
            Add to {label}
          </Button>
          {full && (
            <Text size="sm" c="dimmed">
              No more fit in.
            </Text>
          )}
        </Group>
      )}
      {error !== undefined && (
        <Text size="sm" c="var(--mantine-color-error)">
          {error}
        </Text>
      )}
    </fieldset>
  );
}
