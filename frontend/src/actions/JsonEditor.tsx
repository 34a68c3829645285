import { Input, List, Text } from "@mantine/core";
import { type CSSProperties, Suspense, useEffect, useId, useRef } from "react";
import { lazyPart } from "../ui/lazyPart";
import classes from "./actions.module.css";
import { useForm } from "./fields/context";
import type { FieldError } from "./form/write";

const JsonCode = lazyPart(() => import("./JsonCode"));

interface JsonEditorProps {
  text: string;
  onChange: (text: string) => void;
  /** What it is. */
  label?: string;
  /** Why it cannot be shown as a form. */
  hidden: readonly FieldError[];
}

/** The goal message as JSON, as it is sent. */
export function JsonEditor({ text, onChange, label = "Goal message as JSON", hidden }: JsonEditorProps) {
  const { errors, sought, found } = useForm();
  const id = useId();
  const focused = useRef(false);
  const isSought = sought !== null;

  useEffect(() => {
    if (!isSought) return;
    document.getElementById(id)?.focus();
    found();
  }, [id, isSought, found]);

  const shown = hidden.length > 0 ? hidden : errors;
  const rows = Math.max(6, Math.min(24, text.split("\n").length + 1));
  return (
    <div>
      <Input.Wrapper
        id={id}
        label={label}
        description="Fields that are left out have their defaults. Constants may be given by name, null is NaN."
        labelProps={{ onClick: () => document.getElementById(id)?.focus() }}
        style={{ "--rows": rows } as CSSProperties}
      >
        <Suspense
          fallback={
            <Input
              component="textarea"
              multiline
              readOnly
              error={shown.length > 0}
              classNames={{ input: classes.editor }}
              value={text}
              onFocus={() => {
                focused.current = true;
              }}
              onBlur={() => {
                focused.current = false;
              }}
            />
          }
        >
          <JsonCode
            id={id}
            text={text}
            onChange={onChange}
            errors={shown}
            className={classes.editor}
            focused={focused}
          />
        </Suspense>
      </Input.Wrapper>
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
