import { NumberInput, Stack, TextInput } from "@mantine/core";
import type { UseMutationResult } from "@tanstack/react-query";
import { type FormEvent, useState } from "react";
import type { CreatedToken, TokenBody } from "../api/access";
import type { CommandError } from "../api/errors";
import { SaveBar } from "../ui/Dialog";
import { type Grant, GrantFields, NO_LIMITS, wrongLimits } from "./GrantFields";

/** As the gateway allows. */
const MAX_NAME = 60;
const MAX_DAYS = 3650;
const USUAL_DAYS = 90;

interface TokenFormProps {
  create: UseMutationResult<CreatedToken, CommandError, TokenBody>;
  onDone: (created: CreatedToken) => void;
  onCancel: () => void;
}

/** Creates a token for a person or a script. */
export function TokenForm({ create, onDone, onCancel }: TokenFormProps) {
  const [name, setName] = useState("");
  const [grant, setGrant] = useState<Grant>({ role: "viewer", ...NO_LIMITS });
  const [days, setDays] = useState<number | string>(USUAL_DAYS);
  const [tried, setTried] = useState(false);
  const missing = name.trim() === "";
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (missing || wrongLimits(grant).length > 0) return;
    const body = { name: name.trim(), ...grant, days: typeof days === "number" ? days : null };
    create.mutate(body, { onSuccess: onDone });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <TextInput
          label="Name"
          description="The person or the script that uses it; shown with what is done with it."
          placeholder="Ada"
          autoComplete="off"
          maxLength={MAX_NAME}
          value={name}
          error={tried && missing && "Type a name."}
          onChange={(event) => setName(event.currentTarget.value)}
          data-autofocus
        />
        <GrantFields grant={grant} tried={tried} onChange={(part) => setGrant({ ...grant, ...part })} />
        <NumberInput
          label="Valid for (days)"
          description="Leave empty for a token that is valid until it is revoked."
          min={1}
          max={MAX_DAYS}
          allowDecimal={false}
          clampBehavior="strict"
          value={days}
          onChange={setDays}
        />
        <SaveBar save={create} onCancel={onCancel} verb="Create" command="Creating the token" />
      </Stack>
    </form>
  );
}
