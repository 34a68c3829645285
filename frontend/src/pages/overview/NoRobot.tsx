import { Anchor, Text } from "@mantine/core";
import { Link } from "react-router";
import { Command } from "../../ui/CopyButton";
import { Section } from "../../ui/Section";
import classes from "./overview.module.css";

/** What to do where no robot is on the graph. */
export function NoRobot() {
  const battery = `curl -sX PUT ${window.location.origin}/battery/publisher -d '{"state": {"voltage": 2.16, "percentage": 0.24, "power_supply_status": 3}, "rate_hz": 1}' -H 'Content-Type: application/json'`;
  return (
    <Section title="No robot yet">
      <Text size="sm">
        A robot appears here by itself, as soon as its docking action or its battery topic is on the ROS
        graph. The{" "}
        <Anchor component={Link} to="/ui/graph" inherit underline="always">
          graph
        </Anchor>{" "}
        shows what this gateway sees; where that is nothing, look at ROS_DOMAIN_ID here and there.
      </Text>
      <div className={classes.steps}>
        <Step what="A simulated robot and its docking server">
          <Command line="dock_simulator & docking_server" what="the command that simulates a robot" />
        </Step>
        <Step what="The tutorial's action server">
          <Command line="connect_to_charging_dock_server" what="the command that starts the action server" />
        </Step>
        <Step what="A battery, published by this gateway">
          <Command line={battery} what="the command that publishes a battery" />
        </Step>
      </div>
    </Section>
  );
}

function Step({ what, children }: { what: string; children: React.ReactNode }) {
  return (
    <div>
      <Text size="sm" mb={2}>
        {what}
      </Text>
      {children}
    </div>
  );
}
