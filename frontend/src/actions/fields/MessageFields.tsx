import { Text } from "@mantine/core";
import { isObject, type Json } from "../../api/jsonSchema";
import type { Field, MessageShape } from "../form/shapes";
import type { Bytes, Path, Value, Values } from "../form/values";
import { BytesField } from "./BytesField";
import { ChoiceField } from "./ChoiceField";
import { Fold } from "./Fold";
import classes from "./fields.module.css";
import { ListField } from "./ListField";
import { NumberField, NumbersField, SwitchField, TextField } from "./simple";

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
  /** Whether there is nothing else to fill in beside it. */
  alone?: boolean;
}

/** The input for one field, or for one item of a list. */
export function FieldInput({ field, label, path, value, sent, alone = false }: FieldInputProps) {
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
