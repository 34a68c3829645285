import { Badge, Group, Paper, Text } from "@mantine/core";
import { type ReactNode, useId } from "react";
import { Fact, FactList } from "../ui/Fact";
import { Time } from "../ui/Time";
import classes from "./access.module.css";
import { type Grant, limitWords } from "./GrantFields";

interface AccountItemProps {
  account: Grant & { name: string; created_by?: string | null; created_at: string };
  /** Why it cannot be used, in a word. */
  flaw: string | null;
  /** What happened first. */
  begun: string;
  /** More facts. */
  children: ReactNode;
  buttons: ReactNode;
}

/** A user, a person or a token: whose it is, what they may do, and since when. */
export function AccountItem({ account, flaw, begun, children, buttons }: AccountItemProps) {
  const { name, role, created_by, created_at } = account;
  const titleId = useId();
  const limits = limitWords(account);
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
          {flaw !== null && <Badge color="orange">{flaw}</Badge>}
        </Group>
        <FactList wide>
          <Fact name={begun}>
            <Time value={created_at} /> {byWords(created_by)}
          </Fact>
          {limits !== "" && <Fact name="Only for">{limits}</Fact>}
          {children}
        </FactList>
      </div>
      {buttons}
    </Paper>
  );
}

function byWords(created_by: string | null | undefined): string {
  if (created_by === undefined) return "";
  return created_by === null ? "in a terminal" : `by ${created_by}`;
}

export function sessionWords(sessions: number): string {
  if (sessions === 0) return "No";
  return sessions === 1 ? "In one browser" : `In ${sessions} browsers`;
}
