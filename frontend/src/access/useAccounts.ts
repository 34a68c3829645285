import { useQueryClient } from "@tanstack/react-query";
import {
  createToken,
  endPersonSessions,
  endSessions,
  listPeople,
  listTokens,
  listUsers,
  putUser,
  removeUser,
  revokeToken,
  type TokenBody,
  type UserBody,
} from "../api/access";
import type { Http } from "../api/http";
import { type Command, useForbidden } from "../api/permissions";
import { useFleet, useFleetLive } from "../fleet/context";
import { useAnswer, useCommand } from "../ui/requests";

/** Between two requests for what others have changed, and who was here (ms). */
const REFETCH_MS = 5000;

/** A list of accounts, and what lists them again after a change. */
function useAccounts<Account>(command: Command, list: (http: Http) => Promise<Account[]>) {
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

/** The users, and what changes them. */
export function useUsers() {
  const { http, accounts: users, error, refetch, renew } = useAccounts("GET /users", listUsers);
  const save = useCommand(({ name, body }: { name: string; body: UserBody }) =>
    putUser(http, name, body).then(renew),
  );
  const remove = useCommand((name: string) => removeUser(http, name).then(renew));
  const logOut = useCommand((name: string) => endSessions(http, name).then(renew));
  return { users, error, refetch, save, remove, logOut };
}

/** Who is logged in with the identity provider, and what ends that. */
export function usePeople() {
  const { http, accounts: people, error, refetch, renew } = useAccounts("GET /people", listPeople);
  const logOut = useCommand((name: string) => endPersonSessions(http, name).then(renew));
  return { people, error, refetch, logOut };
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
