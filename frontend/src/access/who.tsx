import { Text, TextInput } from "@mantine/core";
import { useState } from "react";
import { LIMITS } from "../api/limits.gen";
import { session } from "../api/session";
import { keep, readKept } from "../ui/kept";

const KEY = "dock-gateway-name";
const DASHBOARD = "the dashboard";
export const { maxLength: MAX_NAME } = LIMITS["POST /goals/{goal_id}/notes"].by;

/** The name of the login, which the gateway uses whatever it is sent; null without a login. */
export function loginName(): string | null {
  return session.state.principal?.name ?? null;
}

/** The name of who is logged in, else the one that was given on this computer; empty where none was. */
export function ownName(): string {
  return loginName() ?? readKept(KEY) ?? "";
}

/** Keeps a name on this computer; not that of a login. */
export function setOwnName(name: string): void {
  if (loginName() === null) keep(KEY, name.slice(0, MAX_NAME));
}

/** The name of who stops the robot, which others see. */
export function whoStops(): string {
  return ownName().trim() || DASHBOARD;
}

/** The name that is kept in this browser, as it was when the dialog was opened. */
export function useOwnName(): string {
  return useState(ownName)[0];
}

interface NameInputProps {
  value: string;
  /** Says where the name is shown. */
  description: string;
  onChange: (name: string) => void;
}

/** Who makes a change; asked for only without a login. */
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
