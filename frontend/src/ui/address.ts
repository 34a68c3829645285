import { useCallback, useMemo } from "react";
import { useSearchParams } from "react-router";
import { useLatest } from "./useLatest";

/** A part of what a page shows, as it stands in the page's address. What it does not understand is as it begins. */
export interface Part<T> {
  read(parameters: URLSearchParams): T;
  /** Adds to the parameters; nothing where it is as it begins. */
  write(value: T, parameters: URLSearchParams): void;
}

/** One of some values, or what it is without. */
export function oneOf<Value extends string, Otherwise extends Value | null>(
  name: string,
  values: readonly Value[],
  otherwise: Otherwise,
): Part<Value | Otherwise> {
  return {
    read: (parameters) => values.find((value) => value === parameters.get(name)) ?? otherwise,
    write: (value, parameters) => {
      if (value !== null && value !== otherwise) parameters.set(name, value);
    },
  };
}

/** A text that fits the pattern; empty by default. */
export function text(name: string, pattern = /(?:)/): Part<string> {
  return {
    read: (parameters) => {
      const given = parameters.get(name) ?? "";
      return pattern.test(given) ? given : "";
    },
    write: (value, parameters) => {
      if (value !== "") parameters.set(name, value);
    },
  };
}

/** A name; null by default. */
export function optional(name: string): Part<string | null> {
  const { read, write } = text(name);
  return {
    read: (parameters) => read(parameters) || null,
    write: (value, parameters) => write(value ?? "", parameters),
  };
}

/** Any number of names, each in a parameter of its own. */
export function texts(name: string): Part<readonly string[]> {
  return {
    read: (parameters) => parameters.getAll(name).filter((value) => value !== ""),
    write: (values, parameters) => {
      for (const value of values) parameters.append(name, value);
    },
  };
}

/** A switch, which is off by default. */
export function flag(name: string): Part<boolean> {
  return {
    read: (parameters) => parameters.get(name) === "true",
    write: (on, parameters) => {
      if (on) parameters.set(name, "true");
    },
  };
}

/** What a page shows, as it is kept in its address: so that a link, a reload and *Back* show the same. */
export class Address<View extends object> {
  readonly #parts: [keyof View, Part<View[keyof View]>][];
  /** The view of an address that says nothing. */
  readonly initial: View;

  constructor(parts: { [Key in keyof View]: Part<View[Key]> }) {
    this.#parts = Object.entries(parts) as [keyof View, Part<View[keyof View]>][];
    this.initial = this.read(new URLSearchParams());
  }

  read(parameters: URLSearchParams): View {
    return Object.fromEntries(this.#parts.map(([key, part]) => [key, part.read(parameters)])) as View;
  }

  /** The parameters of a view, in the order of its parts. */
  write(view: View): URLSearchParams {
    const parameters = new URLSearchParams();
    for (const [key, part] of this.#parts) part.write(view[key], parameters);
    return parameters;
  }

  isInitial(view: View): boolean {
    return this.write(view).size === 0;
  }
}

/**
 * What the page's address says is shown, and what changes a part of it.
 *
 * @param step The part whose change is a step that *Back* takes back.
 */
export function useAddress<View extends object>(
  address: Address<View>,
  step?: keyof View,
): [View, (change: Partial<View>) => void] {
  const [parameters, setParameters] = useSearchParams();
  const view = useMemo(() => address.read(parameters), [address, parameters]);
  const latest = useLatest({ view, setParameters });
  const change = useCallback(
    (part: Partial<View>) => {
      latest.current.view = { ...latest.current.view, ...part };
      const replace = step === undefined || !(step in part);
      latest.current.setParameters(address.write(latest.current.view), { replace });
    },
    [address, step],
  );
  return [view, change];
}
