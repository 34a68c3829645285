import { useQuery, useQueryClient } from "@tanstack/react-query";
import { endSessions, listUsers, putUser, removeUser, type User, type UserBody } from "../api/access";
import { type CommandError, toCommandError } from "../api/errors";
import { useForbidden } from "../api/permissions";
import { useFleet, useFleetLive } from "../fleet/context";
import { useCommand } from "../ui/useCommand";

const KEY = ["users"] as const;
/** How often it is asked what others have changed, and who was here (ms). */
const REFETCH_MS = 5000;

/** The users, and what changes them. */
export function useUsers() {
  const { http } = useFleet();
  const client = useQueryClient();
  const live = useFleetLive();
  const forbidden = useForbidden("GET /users");
  const { data, error, refetch } = useQuery<User[], CommandError>({
    queryKey: KEY,
    queryFn: () =>
      listUsers(http).catch((error: unknown) => {
        throw toCommandError(error);
      }),
    enabled: live && forbidden === null,
    refetchInterval: REFETCH_MS,
  });
  const refresh = () => client.invalidateQueries({ queryKey: KEY });
  const save = useCommand(({ name, body }: { name: string; body: UserBody }) =>
    putUser(http, name, body).then(refresh),
  );
  const remove = useCommand((name: string) => removeUser(http, name).then(refresh));
  const logOut = useCommand((name: string) => endSessions(http, name).then(refresh));
  return { users: data, error, refetch, save, remove, logOut };
}
