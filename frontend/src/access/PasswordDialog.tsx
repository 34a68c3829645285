import { PasswordInput, Stack, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { type FormEvent, useState } from "react";
import { changePassword } from "../api/access";
import { LIMITS } from "../api/limits.gen";
import { session } from "../api/session";
import { useFleet } from "../fleet/context";
import { Dialog, SaveBar } from "../ui/Dialog";
import { useCommand } from "../ui/requests";

/** Changes the own password. */
export default function PasswordDialog({ opened, onClose }: { opened: boolean; onClose: () => void }) {
  return (
    <Dialog opened={opened} onClose={onClose} title="Change password">
      {opened && <PasswordForm onDone={onClose} />}
    </Dialog>
  );
}

function PasswordForm({ onDone }: { onDone: () => void }) {
  const { http } = useFleet();
  const change = useCommand((body: { old: string; new: string }) => changePassword(http, body));
  const [old, setOld] = useState("");
  const [password, setPassword] = useState("");
  const [tried, setTried] = useState(false);
  const wrong = change.error?.code === "wrong_password";
  const submit = (event: FormEvent) => {
    event.preventDefault();
    setTried(true);
    if (old === "" || passwordProblem(password) !== null) return;
    change.mutate(
      { old, new: password },
      {
        onSuccess: () => {
          // The page may have seen the end of the stream before its new login was there.
          void session.askAgain();
          notifications.show({ message: "Your password is changed. Other browsers are logged out." });
          onDone();
        },
      },
    );
  };
  return (
    <form onSubmit={submit} noValidate>
      <Stack gap="md">
        <PasswordInput
          label="Old password"
          autoComplete="current-password"
          maxLength={LIMITS["PUT /session/password"].old.maxLength}
          visibilityToggleButtonProps={{ "aria-label": "Show the old password", tabIndex: 0 }}
          value={old}
          error={tried && old === "" ? "Enter your old password." : wrong && "The old password is wrong."}
          onChange={(event) => {
            setOld(event.currentTarget.value);
            change.reset();
          }}
          data-autofocus
        />
        <NewPassword label="New password" value={password} tried={tried} onChange={setPassword} />
        <Text size="sm" c="dimmed">
          You stay logged in here. Everywhere else you are logged out.
        </Text>
        <SaveBar
          save={{ ...change, error: wrong ? null : change.error }}
          onCancel={onDone}
          verb="Change"
          command="Changing the password"
        />
      </Stack>
    </form>
  );
}

const { minLength: SHORTEST, maxLength: LONGEST } = LIMITS["PUT /session/password"].new;

/** What is wrong with a new password; null where nothing is. */
export function passwordProblem(password: string): string | null {
  return [...password].length < SHORTEST ? `Type at least ${SHORTEST} characters.` : null;
}

interface NewPasswordProps {
  label: string;
  value: string;
  /** Whether it may stay empty, and what that means. */
  empty?: string;
  /** What is wrong is said from the first try on. */
  tried: boolean;
  onChange: (password: string) => void;
}

/** The field of a new password. */
export function NewPassword({ label, value, empty, tried, onChange }: NewPasswordProps) {
  const problem = value === "" && empty !== undefined ? null : passwordProblem(value);
  return (
    <PasswordInput
      label={label}
      description={`At least ${SHORTEST} characters; several words are easy to remember.${empty ? ` ${empty}` : ""}`}
      autoComplete="new-password"
      maxLength={LONGEST}
      visibilityToggleButtonProps={{ "aria-label": `Show the ${label.toLowerCase()}`, tabIndex: 0 }}
      value={value}
      error={tried && problem}
      onChange={(event) => onChange(event.currentTarget.value)}
    />
  );
}
