import { TextInput } from "@mantine/core";
import { useState } from "react";
import { MAX_NAME, ownName } from "./who";

/** The name that is kept in this browser, as it was when the dialog was opened. */
export function useOwnName(): string {
  return useState(ownName)[0];
}

interface NameInputProps {
  value: string;
  /** Where the name is shown. */
  description: string;
  onChange: (name: string) => void;
}

/** Who makes a change. */
export function NameInput({ value, description, onChange }: NameInputProps) {
  return (
    <TextInput
      label="Your name"
      description={description}
      autoComplete="name"
      maxLength={MAX_NAME}
      value={value}
      onChange={(event) => onChange(event.currentTarget.value)}
    />
  );
}
