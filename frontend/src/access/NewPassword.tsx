import { PasswordInput } from "@mantine/core";

/** As the gateway allows. */
const SHORTEST = 12;
const LONGEST = 200;

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
