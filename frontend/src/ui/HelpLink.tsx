import { ActionIcon } from "@mantine/core";
import { Link } from "react-router";

/** A *?* that leads to a heading of the documentation, such as `stop#release`. */
export function HelpLink({ to, about }: { to: string; about: string }) {
  return (
    <ActionIcon
      component={Link}
      to={`/ui/help/${to}`}
      variant="default"
      c="dimmed"
      fz="xs"
      size={24}
      radius="xl"
      aria-label={`Help: ${about}`}
      title="Help"
    >
      ?
    </ActionIcon>
  );
}
