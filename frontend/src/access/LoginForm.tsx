import { Button, Group, PasswordInput, Stack, Text } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { type FormEvent, useEffect, useRef, useState } from "react";
import { logIn } from "../api/access";
import { useFleet } from "../fleet/context";
import { Command } from "../ui/Command";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { useCommand } from "../ui/useCommand";
import { session } from "./session";

const CREATE = "dock-gateway token create NAME --role operator";

/** Logs in with a token. */
export default function LoginForm({ onDone }: { onDone?: () => void }) {
  const { http } = useFleet();
  const client = useQueryClient();
  const [token, setToken] = useState("");
  const [missing, setMissing] = useState(false);
  // It is loaded on demand: a dialog has looked for what gets the focus before it came.
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), []);
  const login = useCommand((secret: string) => logIn(http, secret));
  const wrong = login.error?.code === "invalid_token";
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setMissing(token.trim() === "");
    if (token.trim() === "") return field.current?.focus();
    login.mutate(token.trim(), {
      onSuccess: (state) => {
        session.set(state);
        // What was refused while nobody was logged in.
        void client.invalidateQueries();
        onDone?.();
      },
      onError: () => field.current?.select(),
    });
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <PasswordInput
          ref={field}
          label="Token"
          name="token"
          autoComplete="current-password"
          spellCheck={false}
          placeholder="dgw_…"
          visibilityToggleButtonProps={{ "aria-label": "Show the token", tabIndex: 0 }}
          value={token}
          error={
            missing
              ? "Enter your token."
              : wrong && "This token is not valid: it may be mistyped, revoked or expired."
          }
          onChange={(event) => {
            setToken(event.currentTarget.value);
            setMissing(false);
            login.reset();
          }}
        />
        <CommandErrorAlert command="The login" error={wrong ? null : login.error} onClose={login.reset} />
        <Group justify="flex-end">
          <Button type="submit" loading={login.isPending}>
            Log in
          </Button>
        </Group>
        <Stack gap={4}>
          <Text size="sm" c="dimmed">
            A token is a secret text that says who you are and what you may do. An admin creates one for you
            on the page Tokens, or on the gateway's computer with
          </Text>
          <Command line={CREATE} what="the command that creates a token" />
        </Stack>
      </Stack>
    </form>
  );
}
