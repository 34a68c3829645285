import { useSearchParams } from "react-router";
import { useFleetPart } from "../../fleet/context";
import { defaultRobot } from "../../fleet/names";
import { useNaming } from "../../fleet/useNaming";
import { usePageTitle } from "../../ui/usePageTitle";
import { RobotView } from "./RobotView";

/** One robot: `?robot=/robot1`, without it the one that the gateway is configured for. */
export default function RobotPage() {
  const [query] = useSearchParams();
  const asked = query.get("robot");
  const robot = asked === null ? null : `/${asked.replace(/^\/+|\/+$/g, "")}`;
  const naming = useNaming();
  usePageTitle(naming.nameOf(useFleetPart("robots", (robots) => robot ?? defaultRobot(robots))));
  return <RobotView robot={robot} breadcrumb />;
}
