import type { AnyGoal } from "@dock-gateway/client";
import { type ComponentType, createContext, type ReactNode, Suspense, useContext } from "react";
import { useLocation } from "react-router";
import { Guarded } from "../ui/Guarded";
import { type Extension, type Places, type Placing, partsAt, type ReplayLayer } from "./extension";

const ExtensionsContext = createContext<readonly Extension[]>([]);

interface ExtensionsProviderProps {
  value: readonly Extension[];
  children: ReactNode;
}

/** Gives what is inside the extensions. */
export function ExtensionsProvider({ value, children }: ExtensionsProviderProps) {
  return <ExtensionsContext.Provider value={value}>{children}</ExtensionsContext.Provider>;
}

export function useExtensions(): readonly Extension[] {
  return useContext(ExtensionsContext);
}

type PartsProps<Place extends keyof Places> = Places[Place] & {
  at: Place;
  /** Shown where no extension adds something. */
  otherwise?: ReactNode;
};

/** What extensions add at a place, each guarded: one that fails takes no other with it. */
export function Parts<Place extends keyof Places>({ at, otherwise = null, ...given }: PartsProps<Place>) {
  const { pathname } = useLocation();
  const parts = partsAt(useExtensions(), at);
  if (parts.length === 0) return otherwise;
  return parts.map(([name, Part]) => {
    const Any = Part as ComponentType<object>;
    return (
      <Guarded key={name} of={pathname}>
        <Suspense fallback={null}>
          <Any {...given} />
        </Suspense>
      </Guarded>
    );
  });
}

/** What extensions show beside the names of listed goals. */
export function useGoalMarks(
  goals: Parameters<NonNullable<Extension["goalMarks"]>>[0],
): (goalId: string) => ReactNode {
  // The list stays the same: so does the order of the hooks.
  const marks = useExtensions().flatMap(({ goalMarks }) => goalMarks?.(goals) ?? []);
  return (goalId) => marks.map((each) => each.get(goalId)).find((mark) => mark !== undefined);
}

/** What an extension adds to the replay of a goal; null for nothing. */
export function useReplayLayer(goal: AnyGoal): ReplayLayer | null {
  return (
    useExtensions()
      .map(({ replay }) => replay?.(goal) ?? null)
      .find((layer) => layer !== null) ?? null
  );
}

/** How the page's robot is placed by dragging it; null where it is not. */
export function usePlacing(): Placing | null {
  return (
    useExtensions()
      .map(({ placing }) => placing?.() ?? null)
      .find((each) => each !== null) ?? null
  );
}
