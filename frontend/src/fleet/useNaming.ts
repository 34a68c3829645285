import { useCallback, useMemo } from "react";
import { useFleet, useFleetPart, useFleetTopic } from "./context";
import { type Label, Naming } from "./names";

/** The names of all robots; another one only where a name or a group is another. */
export function useNaming(): Naming {
  const labels = useFleetPart("robots", (robots) =>
    JSON.stringify(
      [...robots.values()].map(({ name, display_name, groups }) => ({ name, display_name, groups })),
    ),
  );
  return useMemo(() => new Naming(JSON.parse(labels) as Label[]), [labels]);
}

/** Reads the names at the moment of an event; nothing is rendered anew for them. */
export function useNamesNow(): () => Naming {
  const { store } = useFleet();
  return useCallback(() => new Naming(store.get("robots").values()), [store]);
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
