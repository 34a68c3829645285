import { useQuery } from "@tanstack/react-query";
import { listTags } from "../api/notes";
import { useFleet } from "../fleet/context";

export const TAGS_KEY = ["tags"] as const;

/** The tags that goals have; none while they are not known. */
export function useTags(): readonly string[] {
  const { http } = useFleet();
  const { data } = useQuery({ queryKey: TAGS_KEY, queryFn: () => listTags(http) });
  return data ?? [];
}
