import { Title } from "@mantine/core";
import { usePageTitle } from "../ui/usePageTitle";

export default function ActionPage() {
  usePageTitle("Action");
  return (
    <Title order={1} size="h3">
      Action
    </Title>
  );
}
