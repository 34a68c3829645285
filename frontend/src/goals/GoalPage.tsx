import { Title } from "@mantine/core";
import { usePageTitle } from "../ui/usePageTitle";

export default function GoalPage() {
  usePageTitle("Goal");
  return (
    <Title order={1} size="h3">
      Goal
    </Title>
  );
}
