import { Fragment } from "react";

/** A name that goes on in the next line after one of its underscores or slashes, where it has to. */
export function Breakable({ text }: { text: string }) {
  return text.split(/(?<=[_/])/).map((part, index) => (
    // biome-ignore lint/suspicious/noArrayIndexKey: parts of a text are known by their place alone
    <Fragment key={index}>
      {index > 0 && <wbr />}
      {part}
    </Fragment>
  ));
}
