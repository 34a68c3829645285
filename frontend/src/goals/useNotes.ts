import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useMemo } from "react";
import { type CommandError, toCommandError } from "../api/errors";
import { createNotesApi, type GoalNotes, type NotesApi } from "../api/notes";
import { useFleet } from "../fleet/context";
import { useCommand } from "../ui/useCommand";
import { TAGS_KEY } from "./useTags";

/** How often other people's notes are asked for (ms). */
const REFETCH_MS = 5000;

/** The notes and tags of a goal, and what changes them. */
export function useNotes(goalId: string) {
  const { http } = useFleet();
  const client = useQueryClient();
  const api = useMemo(() => createNotesApi(http, goalId), [http, goalId]);
  const key = ["notes", goalId];
  const { data, error, refetch } = useQuery<GoalNotes, CommandError>({
    queryKey: key,
    queryFn: () =>
      api.read().catch((error: unknown) => {
        throw toCommandError(error);
      }),
    refetchInterval: REFETCH_MS,
  });
  const change = useCommand(async (send: (api: NotesApi) => Promise<GoalNotes>) => {
    await client.cancelQueries({ queryKey: key }); // what it reads is outdated
    client.setQueryData(key, await send(api));
    void client.invalidateQueries({ queryKey: TAGS_KEY });
  });
  return { notes: data ?? null, error, refetch, change };
}
