import { Button, Group, Text } from "@mantine/core";
import { type ReactNode, useEffect, useState } from "react";
import { isArray, isObject, type Json } from "../../api/jsonSchema";
import { errorsIn } from "../form/draft";
import { emptyOf } from "../form/read";
import {
  type Bytes,
  dotted,
  type Field,
  type ListShape,
  type MessageShape,
  type Path,
  type Value,
  type Values,
} from "../form/shapes";
import { lengthWords } from "../form/write";
import { type InputProps, useField, useForm } from "./context";
import classes from "./fields.module.css";
import { BytesField, ChoiceField, NumberField, NumbersField, SwitchField, TextField } from "./inputs";

interface MessageFieldsProps {
  shape: MessageShape;
  values: Values;
  path: Path;
  /** What of it is sent. */
  message: Json | undefined;
}

/** The fields of a message, those of messages inside of it to unfold. */
export function MessageFields({ shape, values, path, message }: MessageFieldsProps) {
  if (shape.fields.length === 0) {
    return (
      <Text size="sm" c="dimmed">
        This message has no fields.
      </Text>
    );
  }
  return (
    <div className={classes.fields}>
      {shape.fields.map((field) => (
        <FieldInput
          key={field.name}
          field={field}
          label={field.name}
          path={[...path, field.name]}
          value={values[field.name] ?? ""}
          sent={isObject(message) ? message[field.name] : undefined}
          alone={shape.fields.length === 1}
        />
      ))}
    </div>
  );
}

interface FieldInputProps {
  field: Field;
  label: string;
  path: Path;
  value: Value;
  sent: Json | undefined;
  /** Whether it is the only field. */
  alone?: boolean;
}

/** The input for one field, or for one item of a list. */
function FieldInput({ field, label, path, value, sent, alone = false }: FieldInputProps) {
  const { shape, description, unit } = field;
  const common = { path, label, description, unit, optional: field.initial === undefined };
  switch (shape.kind) {
    case "boolean":
      return <SwitchField {...common} value={value as boolean} />;
    case "integer":
      return shape.choices.length > 0 ? (
        <ChoiceField {...common} shape={shape} value={value as string} />
      ) : (
        <NumberField {...common} shape={shape} value={value as string} />
      );
    case "float":
      return <NumberField {...common} shape={shape} value={value as string} />;
    case "text":
      return <TextField {...common} shape={shape} value={value as string} />;
    case "numbers":
      return <NumbersField {...common} shape={shape} value={value as string} />;
    case "bytes":
      return <BytesField {...common} shape={shape} value={value as Bytes} />;
    case "list":
      return <ListField {...common} shape={shape} value={value as readonly Value[]} sent={sent} />;
    case "message":
      return (
        <Fold path={path} label={label} type={shape.type} description={description} sent={sent} alone={alone}>
          {() => <MessageFields shape={shape} values={value as Values} path={path} message={sent} />}
        </Fold>
      );
  }
}

interface ListFieldProps extends InputProps<readonly Value[]> {
  shape: ListShape;
  sent: Json | undefined;
}

/** An array, item by item: with as many as there may be. */
function ListField({ path, label, description, value, shape, sent }: ListFieldProps) {
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

interface FoldProps {
  path: Path;
  label: string;
  /** The message's type. */
  type: string;
  description: string | null;
  /** What of it is sent. */
  sent: Json | undefined;
  alone: boolean;
  /** Made when it is unfolded. */
  children: () => ReactNode;
}

/** A message inside of another: folded, but where something is set in it, or there is nothing else to fill in. */
function Fold({ path, label, type, description, sent, alone, children }: FoldProps) {
  const { errors, sought } = useForm();
  const where = dotted(path);
  const wrong = errorsIn(errors, where).length;
  const set = countSet(sent);
  const [open, setOpen] = useState(alone || set > 0);
  const isSought = sought?.startsWith(`${where}.`) === true;

  useEffect(() => {
    if (isSought) setOpen(true);
  }, [isSought]);

  return (
    <details className={classes.fold} open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>
        <span className={classes.name}>{label}</span> <span className={classes.type}>{shortType(type)}</span>
        {set > 0 && <span className={classes.set}>{set} set</span>}
        {wrong > 0 && <span className={classes.wrong}>{wrong} not valid</span>}
      </summary>
      {open && (
        <div className={classes.folded}>
          {description !== null && (
            <Text size="sm" c="dimmed" className={classes.description}>
              {description}
            </Text>
          )}
          {children()}
        </div>
      )}
    </details>
  );
}

/** How many fields of a message are set. */
function countSet(json: Json | undefined): number {
  if (json === undefined) return 0;
  if (isObject(json)) return Object.values(json).reduce<number>((sum, each) => sum + countSet(each), 0);
  return isArray(json) && json.some(isObject)
    ? Math.max(
        1,
        json.reduce<number>((sum, each) => sum + countSet(each), 0),
      )
    : 1;
}

/** Writes a type without the `msg` in the middle, as `ros2` does. */
function shortType(type: string): string {
  return type.replace("/msg/", "/");
}
