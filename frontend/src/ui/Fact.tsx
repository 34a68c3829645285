import { Box, Text } from "@mantine/core";
import type { ReactNode } from "react";
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
