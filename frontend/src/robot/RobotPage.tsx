import { Title } from "@mantine/core";
import { useSearchParams } from "react-router";
import { usePageTitle } from "../ui/usePageTitle";
import { RobotPanels } from "./RobotPanels";
import { RobotScope } from "./RobotScope";

/** One robot: `?robot=/robot1`, without it the one that the gateway is configured for. */
export default function RobotPage() {
  const [query] = useSearchParams();
  const robot = query.get("robot");
  const name = robot ?? "Robot";
  usePageTitle(name);
  return (
    <>
      <Title order={1} size="h3">
        {name}
      </Title>
      <RobotScope key={robot} robot={robot}>
        <RobotPanels />
      </RobotScope>
    </>
  );
}
