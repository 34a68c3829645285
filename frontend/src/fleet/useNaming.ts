import { useMemo } from "react";
import { useFleetTopic } from "./context";
import type { Naming } from "./names";

/** The names of all robots; renders anew only when a name or a group changes. */
export function useNaming(): Naming {
  return useFleetTopic("naming");
}

/** The robots to choose from, by namespace. @param chosen One that is listed in any case. */
export function useRobotOptions(chosen: string | null): { value: string; label: string }[] {
  const robots = useFleetTopic("robots");
  const naming = useNaming();
  return useMemo(
    () =>
      [...new Set([...robots.keys(), ...(chosen === null ? [] : [chosen])])].sort().map((name) => ({
        value: name,
        label: naming.besides(name) === null ? name : naming.fullNameOf(name),
      })),
    [robots, naming, chosen],
  );
}
