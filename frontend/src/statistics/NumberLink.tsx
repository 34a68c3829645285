import { Anchor, Text } from "@mantine/core";
import { Link } from "react-router";

interface NumberLinkProps {
  text: string;
  /** The page that lists the goals behind the number; null where there are none. */
  to: string | null;
  /** What a screen reader says besides: which goals they are. */
  label: string;
}

/** A number that leads to its goals. */
export function NumberLink({ text, to, label }: NumberLinkProps) {
  if (to === null) {
    return (
      <Text span inherit c="dimmed">
        {text}
      </Text>
    );
  }
  return (
    <Anchor component={Link} to={to} inherit aria-label={`${text}: ${label}`}>
      {text}
    </Anchor>
  );
}
