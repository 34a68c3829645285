import { Stack, Switch, TextInput } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { type FormEvent, useState } from "react";
import type { User, UserBody } from "../api/access";
import type { CommandError } from "../api/errors";
import { SaveBar } from "../ui/Dialog";
import { type Grant, GrantFields, NO_LIMITS, wrongLimits } from "./GrantFields";
import { NewPassword, passwordProblem } from "./NewPassword";

/** As the gateway allows. */
const NAME = /^[a-z0-9](?:[a-z0-9._@+-]{0,58}[a-z0-9])?$/;

interface UserFormProps {
  /** Who is changed; null for a new user. */
  user: User | null;
  /** Names that are taken. */
  taken: readonly string[];
  save: UseMutationResult<void, CommandError, { name: string; body: UserBody }>;
  onDone: () => void;
}

/** Adds a user, or changes one. */
export function UserForm({ user, taken, save, onDone }: UserFormProps) {
  const [name, setName] = useState(user?.name ?? "");
  const [grant, setGrant] = useState<Grant>(user === null ? { role: "viewer", ...NO_LIMITS } : grantOf(user));
  const [disabled, setDisabled] = useState(user?.disabled ?? false);
  const [password, setPassword] = useState("");
  const [tried, setTried] = useState(false);
  const wrongName = user === null ? nameProblem(name, taken) : null;
  const keeps = user !== null && password === "";
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (wrongName !== null || (!keeps && passwordProblem(password) !== null) || wrongLimits(grant).length > 0)
      return;
    const body = { ...grant, disabled, ...(keeps ? {} : { password }) };
    save.mutate({ name, body }, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        {user === null && (
          <TextInput
            label="Name"
            description="Used to log in, and shown with what the user does."
            placeholder="ada"
            autoComplete="off"
            autoCapitalize="none"
            spellCheck={false}
            maxLength={60}
            value={name}
            error={tried && wrongName}
            onChange={(event) => setName(event.currentTarget.value.toLowerCase())}
            data-autofocus
          />
        )}
        <GrantFields grant={grant} tried={tried} onChange={(part) => setGrant({ ...grant, ...part })} />
        <NewPassword
          label={user === null ? "Password" : "New password"}
          value={password}
          tried={tried}
          onChange={setPassword}
          {...(user === null ? {} : { empty: "Leave empty to keep the present one." })}
        />
        {user !== null && (
          <Switch
            label="Disabled"
            description="Cannot log in, and is logged out everywhere."
            checked={disabled}
            onChange={(event) => setDisabled(event.currentTarget.checked)}
          />
        )}
        <SaveBar
          save={save}
          onCancel={onDone}
          verb={user === null ? "Add" : "Save"}
          command={user === null ? "Adding the user" : "Saving"}
        />
      </Stack>
    </form>
  );
}

function grantOf({ role, robots, actions, topics }: User): Grant {
  return { role, robots, actions, topics };
}

function nameProblem(name: string, taken: readonly string[]): string | null {
  if (name === "") return "Type a name.";
  if (!NAME.test(name)) return "Names have letters, digits, and . _ - @ + between them.";
  return taken.includes(name) ? "There is a user of this name." : null;
}
