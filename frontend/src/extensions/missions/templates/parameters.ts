/** The parameters that steps use, in order. */
export function usedIn(steps: unknown): string[] {
  const found = new Set<string>();
  const look = (value: unknown) => {
    if (typeof value === "string") {
      if (/^\$[A-Za-z_]\w*$/.test(value)) found.add(value.slice(1));
    } else if (typeof value === "object" && value !== null) Object.values(value).forEach(look);
  };
  look(steps);
  return [...found];
}
