import { Anchor } from "@mantine/core";
import { Link } from "react-router";
import type { GoalCounts } from "../api/types";
import { codeWords } from "../goal/words";
import { ENDS, goalsLink } from "./words";

interface ErrorLinkProps {
  counts: GoalCounts;
  error: GoalCounts["errors"][number];
}

/** What an error code means; leads to the goals that have it. */
export function ErrorLink({ counts, error: { code } }: ErrorLinkProps) {
  return (
    <Anchor component={Link} to={goalsLink(counts, ENDS, code)} inherit>
      {codeWords(code)}
    </Anchor>
  );
}
