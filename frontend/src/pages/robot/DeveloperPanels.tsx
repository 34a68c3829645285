import { Code, Stack, Text } from "@mantine/core";
import { useSession } from "../../api/session";
import { apiAddress } from "../../api/site";
import { PublisherCard } from "../../battery/PublisherCard";
import { CalibrationCard } from "../../docking/CalibrationCard";
import { Parts } from "../../extension/context";
import { currentGoal } from "../../goal/words";
import { useServices, useTopic } from "../../store/context";
import { Command } from "../../ui/CopyButton";
import { Section } from "../../ui/Section";
import classes from "./robot.module.css";

/** What is needed to develop and to try out: a simulated robot's controls, calibration, battery states by hand, command lines. */
export default function DeveloperPanels() {
  return (
    <Stack gap="md">
      <Parts at="developer" />
      <CalibrationCard />
      <PublisherCard />
      <CurlCard />
    </Stack>
  );
}

/** The commands of the page for a terminal. */
export function CurlCard() {
  const { robot } = useServices();
  const goal = currentGoal(useTopic("courses"));
  const { required } = useSession();
  return (
    <Section title="From a terminal" help="clients#in-ten-lines">
      {required && (
        <Text size="sm">
          Each needs a token, too: <Code>-H 'Authorization: Bearer dgw_…'</Code>
        </Text>
      )}
      <div className={classes.commands}>
        {commands(robot, `goals/${goal?.goal_id ?? "GOAL_ID"}`).map(({ what, line }) => (
          <div key={what}>
            <Text size="sm" mb={2}>
              {what}
            </Text>
            <Command line={line} what={`the command: ${what}`} />
          </div>
        ))}
      </div>
    </Section>
  );
}

/** @param robot Its namespace; null for the one that the gateway is configured for. */
function commands(robot: string | null, goal: string): { what: string; line: string }[] {
  const address = apiAddress();
  // A shell takes a question mark for a pattern.
  const url = (base: string) => (robot === null ? base : `'${base}?robot=${robot}'`);
  const stream = url(`${address.replace(/^http/, "ws")}/ws/feedback`);
  return [
    { what: "Dock", line: `curl -sX POST ${url(`${address}/dock`)}` },
    {
      what: "Dock, and wait for the end",
      line: `curl -sX POST ${url(`${address}/dock`)} -H 'Prefer: wait=60'`,
    },
    { what: "Look at the goal", line: `curl -s ${address}/${goal}` },
    { what: "Cancel it", line: `curl -sX POST ${address}/${goal}/cancel` },
    { what: "Undock", line: `curl -sX POST ${url(`${address}/undock`)}` },
    {
      what: robot === null ? "Stop every robot, and keep it stopped" : "Stop the robot, and keep it stopped",
      line: `curl -sX POST ${url(`${address}/stop`)}`,
    },
    { what: "Release the stop", line: `curl -sX DELETE ${url(`${address}/stop`)}` },
    {
      what: "Publish a low battery once a second",
      line: `curl -sX PUT ${url(`${address}/battery/publisher`)} -d '{"state": {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 3}, "rate_hz": 1}' -H 'Content-Type: application/json'`,
    },
    { what: "Watch the feedback", line: `websocat ${stream}` },
  ];
}
