import { useQuery, useQueryClient } from "@tanstack/react-query";
import { createToken, listTokens, revokeToken, type Token, type TokenBody } from "../api/access";
import { type CommandError, toCommandError } from "../api/errors";
import { useForbidden } from "../api/permissions";
import { useFleet, useFleetLive } from "../fleet/context";
import { useCommand } from "../ui/useCommand";

const KEY = ["tokens"] as const;
/** How often it is asked what others have changed, and who was here (ms). */
const REFETCH_MS = 5000;

/** The tokens, and what changes them. */
export function useTokens() {
  const { http } = useFleet();
  const client = useQueryClient();
  const live = useFleetLive();
  const forbidden = useForbidden("GET /tokens");
  const { data, error, refetch } = useQuery<Token[], CommandError>({
    queryKey: KEY,
    queryFn: () =>
      listTokens(http).catch((error: unknown) => {
        throw toCommandError(error);
      }),
    enabled: live && forbidden === null,
    refetchInterval: REFETCH_MS,
  });
  const create = useCommand(async (body: TokenBody) => {
    const created = await createToken(http, body);
    await client.invalidateQueries({ queryKey: KEY });
    return created;
  });
  const revoke = useCommand(async (id: string) => {
    await revokeToken(http, id);
    await client.invalidateQueries({ queryKey: KEY });
  });
  return { tokens: data, error, refetch, create, revoke };
}
