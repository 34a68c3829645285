import { Code } from "@mantine/core";
import { CopyButton } from "./CopyButton";
import classes from "./ui.module.css";

/** A line to copy into a terminal. */
export function Command({ line, what }: { line: string; what: string }) {
  return (
    <div className={classes.command}>
      <Code>{line}</Code>
      <CopyButton value={line} what={what} />
    </div>
  );
}
