import { type ComponentType, createContext, type ReactNode, Suspense, useContext } from "react";
import { useLocation } from "react-router";
import { Guarded } from "../ui/Guarded";
import { type Extension, type Places, partsAt } from "./extension";

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
  /** A part that fails leaves its place empty. */
  quiet?: true;
};

/** What extensions add at a place, each guarded: one that fails takes no other with it. */
export function Parts<Place extends keyof Places>({ at, quiet, ...given }: PartsProps<Place>) {
  const { pathname } = useLocation();
  return partsAt(useExtensions(), at).map(([name, Part]) => {
    const Any = Part as ComponentType<object>;
    return (
      <Guarded key={name} of={pathname} what={quiet ? null : `The extension ${name}`}>
        <Suspense fallback={null}>
          <Any {...given} />
        </Suspense>
      </Guarded>
    );
  });
}
