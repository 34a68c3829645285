import type { ClientError, Http } from "@dock-gateway/client";
import { Badge, Group, Paper, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { useQueryClient } from "@tanstack/react-query";
import { type ReactNode, useId } from "react";
import {
  createToken,
  endSessions,
  listTokens,
  listUsers,
  putUser,
  removeUser,
  revokeToken,
  type TokenBody,
  type User,
  type UserBody,
} from "../api/access";
import { type Command, useForbidden } from "../api/session";
import type { Base } from "../api/version";
import { useFleet, useFleetLive } from "../fleet/context";
import { Fact, FactList } from "../ui/Fact";
import { useAnswer, useCommand } from "../ui/requests";
import { Time } from "../ui/Time";
import classes from "./access.module.css";
import { type Grant, limitWords } from "./accountForms";

/** Between two requests for what others have changed, and who was here (ms). */
const REFETCH_MS = 5000;

/** A list of accounts, and what lists them again after a change. */
export function useAccounts<Account>(command: Command, list: (http: Http) => Promise<Account[]>) {
  const { http } = useFleet();
  const client = useQueryClient();
  const live = useFleetLive();
  const forbidden = useForbidden(command);
  const { data, error, refetch } = useAnswer({
    queryKey: [command],
    queryFn: () => list(http),
    enabled: live && forbidden === null,
    refetchInterval: REFETCH_MS,
  });
  const renew = () => client.invalidateQueries({ queryKey: [command] });
  return { http, accounts: data, error, refetch, renew };
}

/** A change of a user, or a new one. */
export interface SavedUser {
  name: string;
  body: UserBody;
  base: Base;
}

/** The users, and what changes them. */
export function useUsers() {
  const { http, accounts: users, error, refetch, renew } = useAccounts("GET /users", listUsers);
  const save = useCommand(({ name, body, base }: SavedUser) =>
    putUser(http, name, body, base).finally(renew),
  );
  const remove = useCommand((user: User) => removeUser(http, user).finally(renew));
  const logOut = useCommand((name: string) => endSessions(http, name).then(renew));
  return { users, error, refetch, save, remove, logOut };
}

/** The tokens, and what changes them. */
export function useTokens() {
  const { http, accounts: tokens, error, refetch, renew } = useAccounts("GET /tokens", listTokens);
  const create = useCommand(async (body: TokenBody) => {
    const created = await createToken(http, body);
    await renew();
    return created;
  });
  const revoke = useCommand((id: string) => revokeToken(http, id).then(renew));
  return { tokens, error, refetch, create, revoke };
}

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

/** Says what came of logging somebody out everywhere. */
export function loggedOutNotice(name: string) {
  return {
    onSuccess: () => void notifications.show({ message: `${name} is logged out everywhere.` }),
    onError: ({ title, detail }: ClientError) =>
      void notifications.show({
        color: "red",
        title: `${name} is still logged in: ${title}`,
        message: detail,
      }),
  };
}
