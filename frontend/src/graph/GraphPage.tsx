import { Title } from "@mantine/core";
import { usePageTitle } from "../ui/usePageTitle";

export default function GraphPage() {
  usePageTitle("Graph");
  return (
    <Title order={1} size="h3">
      Graph
    </Title>
  );
}
