import { TextInput } from "@mantine/core";
import { useState } from "react";
import { MAX_NAME, ownName } from "../stop/who";

/** The name that is kept in this browser, as it was when the dialog was opened. */
export function useOwnName(): string {
  return useState(ownName)[0];
}

/** Who changes a rule. */
export function NameInput({ value, onChange }: { value: string; onChange: (name: string) => void }) {
  return (
    <TextInput
      label="Your name"
      description="Shown beside the rule."
      autoComplete="name"
      maxLength={MAX_NAME}
      value={value}
      onChange={(event) => onChange(event.currentTarget.value)}
    />
  );
}
