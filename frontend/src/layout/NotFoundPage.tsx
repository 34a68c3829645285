import { Anchor, Text, Title } from "@mantine/core";
import { Link } from "react-router";
import { usePageTitle } from "../ui/usePageTitle";

/** For an address that is no page. */
export function NotFoundPage() {
  usePageTitle("No such page");
  return (
    <>
      <Title order={1} size="h3">
        There is no such page
      </Title>
      <Text>
        Everything begins at the{" "}
        <Anchor component={Link} to="/">
          overview
        </Anchor>
        .
      </Text>
    </>
  );
}
