import { VisuallyHidden } from "@mantine/core";
import { RobotPanels } from "../robot/RobotPanels";
import { RobotScope } from "../robot/RobotScope";
import { usePageTitle } from "../ui/usePageTitle";

/** All robots; a single one with all that there is to see and do. */
export default function OverviewPage() {
  usePageTitle("Overview");
  return (
    <>
      <VisuallyHidden>
        <h1>Overview</h1>
      </VisuallyHidden>
      <RobotScope robot={null}>
        <RobotPanels />
      </RobotScope>
    </>
  );
}
