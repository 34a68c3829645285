import { Text, TextInput } from "@mantine/core";
import { useState } from "react";
import { loginName, MAX_NAME, ownName } from "./who";

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

/** Who makes a change; asked for only where nobody is logged in. */
export function NameInput({ value, description, onChange }: NameInputProps) {
  const known = loginName();
  if (known !== null)
    return (
      <Text size="sm" c="dimmed">
        Saved as {known}
      </Text>
    );
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
