import { SegmentedControl, Textarea } from "@mantine/core";
import { convertBytes, countBytes } from "../form/numbers";
import type { BytesShape } from "../form/shapes";
import type { Bytes } from "../form/values";
import { lengthWords } from "../form/write";
import { type InputProps, ORDER, useField } from "./context";
import classes from "./fields.module.css";
import { rowsFor } from "./simple";

interface BytesFieldProps extends InputProps<Bytes> {
  shape: BytesShape;
}

/** `uint8[]`, as numbers or as base64. */
export function BytesField({ path, label, description, value, shape, optional }: BytesFieldProps) {
  const { ref, error, set } = useField<HTMLTextAreaElement>(path);
  const count = countBytes(value);
  return (
    <div className={classes.wide}>
      <Textarea
        ref={ref}
        label={label}
        description={
          <>
            {description}
            {description !== null && <br />}
            {count ?? "?"} of {lengthWords(shape, "byte") || "any number of bytes"}
            {value.encoding === "numbers" ? ": 0 to 255, between commas or spaces" : ", as base64"}
          </>
        }
        error={error}
        rows={rowsFor(value.text)}
        autoComplete="off"
        spellCheck={false}
        placeholder={optional ? "as in the definition" : undefined}
        inputWrapperOrder={ORDER}
        classNames={{ input: classes.numbers, description: classes.description }}
        value={value.text}
        onChange={(event) => set({ ...value, text: event.currentTarget.value })}
      />
      <SegmentedControl
        size="xs"
        mt={4}
        aria-label={`${label} as`}
        value={value.encoding}
        onChange={(encoding) => set(convertBytes(value, encoding as Bytes["encoding"]))}
        data={[
          { label: "Numbers", value: "numbers" },
          { label: "Base64", value: "base64" },
        ]}
      />
    </div>
  );
}
