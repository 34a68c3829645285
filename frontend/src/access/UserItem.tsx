import { Group } from "@mantine/core";
import type { User } from "../api/access";
import { ENTRY_BUTTON } from "../ui/EntryCard";
import { Fact } from "../ui/Fact";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import { AccountItem } from "./AccountItem";
import { sessionWords } from "./words";

interface UserItemProps {
  user: User;
  /** Why nothing can be changed now; null where it can. */
  reason: string | null;
  onEdit: () => void;
  onLogOut: () => void;
  onRemove: () => void;
}

/** A user: what they may do, and where they are logged in. */
export function UserItem({ user, reason, onEdit, onLogOut, onRemove }: UserItemProps) {
  const { name, logged_in_at, disabled, sessions } = user;
  return (
    <AccountItem
      account={user}
      flaw={disabled ? "disabled" : null}
      begun="Added"
      buttons={
        <Group gap="xs">
          <ReasonButton {...ENTRY_BUTTON} reason={reason} aria-label={`Edit ${name}`} onClick={onEdit}>
            Edit
          </ReasonButton>
          <ReasonButton
            {...ENTRY_BUTTON}
            reason={reason ?? (sessions === 0 ? `${name} is not logged in.` : null)}
            aria-label={`Log out ${name}`}
            onClick={onLogOut}
          >
            Log out
          </ReasonButton>
          <ReasonButton {...ENTRY_BUTTON} reason={reason} aria-label={`Remove ${name}`} onClick={onRemove}>
            Remove
          </ReasonButton>
        </Group>
      }
    >
      <Fact name="Last login">{logged_in_at === null ? "Never" : <Time value={logged_in_at} />}</Fact>
      <Fact name="Logged in">{sessionWords(sessions)}</Fact>
    </AccountItem>
  );
}
