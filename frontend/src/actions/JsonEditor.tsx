import { List, Text, Textarea } from "@mantine/core";
import { useEffect, useRef } from "react";
import classes from "./actions.module.css";
import { useForm } from "./fields/context";
import type { FieldError } from "./form/write";

interface JsonEditorProps {
  text: string;
  onChange: (text: string) => void;
  /** Why it cannot be shown as a form. */
  hidden: readonly FieldError[];
}

/** The goal message as JSON, as it is sent. */
export function JsonEditor({ text, onChange, hidden }: JsonEditorProps) {
  const { errors, sought, found } = useForm();
  const ref = useRef<HTMLTextAreaElement>(null);
  const isSought = sought !== null;

  useEffect(() => {
    if (!isSought) return;
    ref.current?.focus();
    found();
  }, [isSought, found]);

  const shown = hidden.length > 0 ? hidden : errors;
  return (
    <div>
      <Textarea
        ref={ref}
        label="Goal message as JSON"
        description="Fields that are left out have their defaults. Constants may be given by name, null is NaN."
        rows={Math.max(6, Math.min(24, text.split("\n").length + 1))}
        spellCheck={false}
        autoComplete="off"
        error={shown.length > 0}
        classNames={{ input: classes.editor }}
        value={text}
        onChange={(event) => onChange(event.currentTarget.value)}
      />
      <div role="status">
        {shown.length > 0 && (
          <>
            {hidden.length > 0 && (
              <Text size="sm" mt="xs" fw={600}>
                The form cannot show this:
              </Text>
            )}
            <List size="sm" mt={4} className={classes.wrong}>
              {shown.map(({ path, detail }) => (
                <List.Item key={`${path} ${detail}`}>
                  {path !== "" && <strong>{path}: </strong>}
                  {detail}
                </List.Item>
              ))}
            </List>
          </>
        )}
      </div>
    </div>
  );
}
