import { Button, Group, PasswordInput, Stack, Text, TextInput } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { type FormEvent, useEffect, useRef, useState } from "react";
import { type LoginBody, logIn } from "../api/access";
import { LIMITS } from "../api/limits.gen";
import { session } from "../api/session";
import { Parts } from "../extension/context";
import { useFleet } from "../fleet/context";
import { Command } from "../ui/CopyButton";
import { CommandErrorAlert } from "../ui/errors";
import { useCommand } from "../ui/requests";

const { user: USER, password: PASSWORD } = LIMITS["POST /session"];
const ADD_USER = "dock-gateway user create NAME --role operator";
const CREATE_TOKEN = "dock-gateway token create NAME --role operator";

/** Logs in with a name and a password, or with a token. */
export default function LoginForm({ onDone }: { onDone?: () => void }) {
  const { http } = useFleet();
  const client = useQueryClient();
  const [byToken, setByToken] = useState(false);
  const login = useCommand((body: LoginBody) => logIn(http, body));
  const submit = (body: LoginBody, onError: () => void) =>
    login.mutate(body, {
      onSuccess: (state) => {
        session.set(state);
        // What was refused without a login.
        void client.invalidateQueries();
        onDone?.();
      },
      onError,
    });
  const Fields = byToken ? TokenFields : PasswordFields;
  const toggle = () => {
    setByToken(!byToken);
    login.reset();
  };
  return (
    <Stack gap="md">
      <Parts at="login" />
      <Fields login={login} submit={submit} />
      <Button variant="subtle" onClick={toggle}>
        {byToken ? "Log in with a password" : "Log in with a token"}
      </Button>
    </Stack>
  );
}

interface FieldsProps {
  login: ReturnType<typeof useCommand<unknown, LoginBody>>;
  submit: (body: LoginBody, onError: () => void) => void;
}

function PasswordFields({ login, submit }: FieldsProps) {
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  const [tried, setTried] = useState(false);
  const nameField = useFirstFocus();
  const passwordField = useRef<HTMLInputElement>(null);
  const wrong = login.error?.code === "invalid_login";
  const send = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (name.trim() === "") return nameField.current?.focus();
    if (password === "") return passwordField.current?.focus();
    submit({ user: name.trim(), password }, () => passwordField.current?.select());
  };
  return (
    <form onSubmit={send} noValidate>
      <Stack gap="md">
        <TextInput
          ref={nameField}
          label="Name"
          name="username"
          autoComplete="username"
          autoCapitalize="none"
          spellCheck={false}
          maxLength={USER.maxLength}
          value={name}
          error={tried && name.trim() === "" && "Enter your name."}
          onChange={(event) => {
            setName(event.currentTarget.value);
            login.reset();
          }}
        />
        <PasswordInput
          ref={passwordField}
          label="Password"
          name="password"
          autoComplete="current-password"
          maxLength={PASSWORD.maxLength}
          visibilityToggleButtonProps={{ "aria-label": "Show the password", tabIndex: 0 }}
          value={password}
          error={
            tried && password === ""
              ? "Enter your password."
              : wrong && "The name or the password is wrong, or the user is disabled."
          }
          onChange={(event) => {
            setPassword(event.currentTarget.value);
            login.reset();
          }}
        />
        <LoginBar login={login} shown={wrong} />
        <Hint line={ADD_USER} what="the command that adds a user">
          An admin adds you on the page Users, or on the gateway's computer with
        </Hint>
      </Stack>
    </form>
  );
}

function TokenFields({ login, submit }: FieldsProps) {
  const [token, setToken] = useState("");
  const [tried, setTried] = useState(false);
  const field = useFirstFocus();
  const wrong = login.error?.code === "invalid_token";
  const send = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (token.trim() === "") return field.current?.focus();
    submit({ token: token.trim() }, () => field.current?.select());
  };
  return (
    <form onSubmit={send} noValidate>
      <Stack gap="md">
        <PasswordInput
          ref={field}
          label="Token"
          name="token"
          autoComplete="off"
          spellCheck={false}
          placeholder="dgw_…"
          visibilityToggleButtonProps={{ "aria-label": "Show the token", tabIndex: 0 }}
          value={token}
          error={
            tried && token.trim() === ""
              ? "Enter your token."
              : wrong && "This token is not valid: it may be mistyped, revoked or expired."
          }
          onChange={(event) => {
            setToken(event.currentTarget.value);
            login.reset();
          }}
        />
        <LoginBar login={login} shown={wrong} />
        <Hint line={CREATE_TOKEN} what="the command that creates a token">
          A token is a secret text that says who you are and what you may do. An admin creates one on the page
          Tokens, or on the gateway's computer with
        </Hint>
      </Stack>
    </form>
  );
}

/** The field that has the focus first. The form is loaded on demand: a dialog has looked for one before it came. */
function useFirstFocus() {
  const field = useRef<HTMLInputElement>(null);
  useEffect(() => field.current?.focus(), []);
  return field;
}

/** @param shown Whether the error is shown at a field already. */
function LoginBar({ login, shown }: { login: FieldsProps["login"]; shown: boolean }) {
  return (
    <>
      <CommandErrorAlert command="The login" error={shown ? null : login.error} onClose={login.reset} />
      <Group justify="flex-end">
        <Button type="submit" loading={login.isPending}>
          Log in
        </Button>
      </Group>
    </>
  );
}

function Hint({ line, what, children }: { line: string; what: string; children: string }) {
  return (
    <Stack gap={4}>
      <Text size="sm" c="dimmed">
        {children}
      </Text>
      <Command line={line} what={what} />
    </Stack>
  );
}
