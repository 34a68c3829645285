import { Box, Text } from "@mantine/core";
import { Fragment, type ReactNode } from "react";
import classes from "./ui.module.css";

/** A name and its value, for use in a FactList. */
export function Fact({ name, children }: { name: string; children: ReactNode }) {
  return (
    <Box>
      <Text component="dt" size="sm" c="dimmed">
        {name}
      </Text>
      <Text component="dd" m={0} className={classes.value}>
        {children}
      </Text>
    </Box>
  );
}

/** Facts side by side; `wide` where their values are more than a number. */
export function FactList({ wide = false, children }: { wide?: boolean; children: ReactNode }) {
  return (
    <dl className={classes.facts} data-wide={wide || undefined}>
      {children}
    </dl>
  );
}

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
