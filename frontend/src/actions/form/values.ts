/**
 * What a form holds: numbers as the text that was typed, arrays of numbers as one text, bytes with how they are
 * written, lists and messages as trees of those.
 */
export type Value = boolean | string | Bytes | readonly Value[] | Values;

export interface Values {
  readonly [name: string]: Value;
}

export interface Bytes {
  readonly encoding: "numbers" | "base64";
  readonly text: string;
}

/** Where a value is: names of fields, and numbers of list items. */
export type Path = readonly (string | number)[];

/** A path as the gateway's errors have it: `pose.covariance.3`. */
export function dotted(path: Path): string {
  return path.join(".");
}

/** The tree with another value at the path. */
export function withValue<Tree extends Value>(tree: Tree, path: Path, value: Value): Tree {
  const [step, ...rest] = path;
  if (step === undefined) return value as Tree;
  if (Array.isArray(tree)) {
    return (tree as readonly Value[]).map((item, index) =>
      index === step ? withValue(item, rest, value) : item,
    ) as unknown as Tree;
  }
  const values = tree as Values;
  return { ...values, [step]: withValue(values[step] ?? "", rest, value) } as unknown as Tree;
}
