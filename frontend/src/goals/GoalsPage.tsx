import { Title } from "@mantine/core";
import { usePageTitle } from "../ui/usePageTitle";

export default function GoalsPage() {
  usePageTitle("Goals");
  return (
    <Title order={1} size="h3">
      Goals
    </Title>
  );
}
