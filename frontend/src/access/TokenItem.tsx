import { Badge, Group, Paper, Text } from "@mantine/core";
import { useId } from "react";
import type { Token } from "../api/access";
import { ENTRY_BUTTON } from "../ui/EntryCard";
import { Fact, FactList } from "../ui/Fact";
import { ReasonButton } from "../ui/ReasonButton";
import { Time } from "../ui/Time";
import classes from "./access.module.css";
import { limitWords } from "./GrantFields";

interface TokenItemProps {
  token: Token;
  /** Why it cannot be revoked now; null where it can. */
  reason: string | null;
  onRevoke: () => void;
}

/** A token: whose it is, what they may do, and until when. */
export function TokenItem({ token, reason, onRevoke }: TokenItemProps) {
  const { name, role, created_by, created_at, expires_at, used_at, valid } = token;
  const titleId = useId();
  const limits = limitWords(token);
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
          {!valid && <Badge color="orange">expired</Badge>}
        </Group>
        <FactList wide>
          <Fact name="Created">
            <Time value={created_at} /> {created_by === null ? "in a terminal" : `by ${created_by}`}
          </Fact>
          <Fact name={valid ? "Expires" : "Expired"}>
            {expires_at === null ? "Never" : <Time value={expires_at} />}
          </Fact>
          {limits !== "" && <Fact name="Only for">{limits}</Fact>}
          <Fact name="Last used">{used_at === null ? "Never" : <Time value={used_at} />}</Fact>
        </FactList>
      </div>
      <ReasonButton {...ENTRY_BUTTON} reason={reason} aria-label={`Revoke ${name}`} onClick={onRevoke}>
        Revoke
      </ReasonButton>
    </Paper>
  );
}
