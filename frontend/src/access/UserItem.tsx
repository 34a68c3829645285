import { Badge, Group, Paper, Text } from "@mantine/core";
import { useId } from "react";
import type { User } from "../api/access";
import { ENTRY_BUTTON } from "../ui/EntryCard";
import { Fact, FactList } from "../ui/Fact";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import classes from "./access.module.css";
import { limitWords } from "./GrantFields";

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
  const { name, role, created_by, created_at, logged_in_at, disabled, sessions } = user;
  const titleId = useId();
  const limits = limitWords(user);
  return (
    <Paper
      component="li"
      withBorder
      radius="md"
      p={{ base: "md", sm: "lg" }}
      className={classes.token ?? ""}
      aria-labelledby={titleId}
    >
      <div className={classes.facts}>
        <Group gap="xs" mb="xs">
          <Text fw={600} id={titleId} style={{ overflowWrap: "anywhere" }}>
            {name}
          </Text>
          <Text c="dimmed">{role}</Text>
          {disabled && <Badge color="orange">disabled</Badge>}
        </Group>
        <FactList wide>
          <Fact name="Added">
            <Time value={created_at} /> {created_by === null ? "in a terminal" : `by ${created_by}`}
          </Fact>
          {limits !== "" && <Fact name="Only for">{limits}</Fact>}
          <Fact name="Last login">{logged_in_at === null ? "Never" : <Time value={logged_in_at} />}</Fact>
          <Fact name="Logged in">{sessionWords(sessions)}</Fact>
        </FactList>
      </div>
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
    </Paper>
  );
}

function sessionWords(sessions: number): string {
  if (sessions === 0) return "No";
  return sessions === 1 ? "In one browser" : `In ${sessions} browsers`;
}
