import { Text } from "@mantine/core";
import { currentGoal } from "../docking/goalWords";
import { useTopic } from "../store/context";
import { newestFirst } from "../store/goals";
import { useVerbOf } from "../store/verbs";
import { Command } from "../ui/Command";
import { Section } from "../ui/Section";
import classes from "./robot.module.css";

/** The same from a terminal. */
export function CurlCard() {
  const goal = currentGoal(newestFirst(useTopic("goals")));
  const verb = useVerbOf()({ action_name: goal?.action_name ?? "" });
  return (
    <Section title="From a terminal">
      <div className={classes.commands}>
        {commands(window.location, `${verb}/${goal?.goal_id ?? "GOAL_ID"}`).map(({ what, line }) => (
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

function commands(location: Location, goal: string): { what: string; line: string }[] {
  const { origin, host, protocol } = location;
  const stream = `${protocol === "https:" ? "wss" : "ws"}://${host}/ws/feedback`;
  return [
    { what: "Dock", line: `curl -sX POST ${origin}/dock` },
    { what: "Dock, and wait for the end", line: `curl -sX POST ${origin}/dock -H 'Prefer: wait=60'` },
    { what: "Look at the goal", line: `curl -s ${origin}/${goal}` },
    { what: "Cancel it", line: `curl -sX POST ${origin}/${goal}/cancel` },
    { what: "Undock", line: `curl -sX POST ${origin}/undock` },
    { what: "Stop the robot, and keep it stopped", line: `curl -sX POST ${origin}/stop` },
    { what: "Release the stop", line: `curl -sX DELETE ${origin}/stop` },
    {
      what: "Publish a low battery once a second",
      line: `curl -sX PUT ${origin}/battery/publisher -d '{"state": {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 3}, "rate_hz": 1}' -H 'Content-Type: application/json'`,
    },
    { what: "Watch the feedback", line: `websocat ${stream}` },
  ];
}
