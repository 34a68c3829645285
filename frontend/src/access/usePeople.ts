import { useQuery, useQueryClient } from "@tanstack/react-query";
import { endPersonSessions, listPeople, type Person } from "../api/access";
import { type CommandError, toCommandError } from "../api/errors";
import { useForbidden } from "../api/permissions";
import { useFleet, useFleetLive } from "../fleet/context";
import { useCommand } from "../ui/useCommand";

const KEY = ["people"] as const;
/** How often it is asked who has come and gone (ms). */
const REFETCH_MS = 5000;

/** Who is logged in with the identity provider, and what ends that. */
export function usePeople() {
  const { http } = useFleet();
  const client = useQueryClient();
  const live = useFleetLive();
  const forbidden = useForbidden("GET /people");
  const { data, error, refetch } = useQuery<Person[], CommandError>({
    queryKey: KEY,
    queryFn: () =>
      listPeople(http).catch((error: unknown) => {
        throw toCommandError(error);
      }),
    enabled: live && forbidden === null,
    refetchInterval: REFETCH_MS,
  });
  const logOut = useCommand((name: string) =>
    endPersonSessions(http, name).then(() => client.invalidateQueries({ queryKey: KEY })),
  );
  return { people: data, error, refetch, logOut };
}
