import { Title } from "@mantine/core";
import { usePageTitle } from "../ui/usePageTitle";

export default function ActionsPage() {
  usePageTitle("Actions");
  return (
    <Title order={1} size="h3">
      Actions
    </Title>
  );
}
