import { Badge, Code, Stack, Text, useComputedColorScheme } from "@mantine/core";
import { useId, useState } from "react";
import type { Scene } from "../api/types";
import { VelocityLine } from "../docking/VelocityLine";
import { useLive, useServices, useTopic } from "../store/context";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Section } from "../ui/Section";
import { useCommand } from "../ui/useCommand";
import { SCENE_COLORS } from "./colors";
import type { Pose } from "./geometry";
import { SceneCanvas } from "./SceneCanvas";
import classes from "./scene.module.css";
import { useScene } from "./useScene";
import { describePose, describeScene } from "./words";

/** The robot and its dock from above, in a picture and in words. */
export function SceneCard() {
  const { gateway } = useServices();
  const live = useLive();
  const simulator = useTopic("simulator");
  const { scene, fresh } = useScene();
  const [ghost, setGhost] = useState<Pose | null>(null);
  const wordsId = useId();
  const place = useCommand((pose: Pose) => gateway.placeRobot(pose));
  const placeable = live && fresh && simulator !== null;

  return (
    <Section title="From above" aside={<Freshness live={live} known={scene !== null} fresh={fresh} />}>
      {scene === null ? (
        <NoScene live={live} simulated={simulator !== null} />
      ) : (
        <Stack gap="xs">
          <SceneCanvas
            placeable={placeable}
            describedBy={wordsId}
            onGhost={setGhost}
            onPlace={async (pose) => {
              setGhost(null);
              // What went wrong is shown below.
              await place.mutateAsync(pose).catch(() => {});
            }}
          />
          <Text size="sm" id={wordsId} data-testid="scene-words" className="tabular">
            {!fresh && "This is how it was last seen. "}
            {describeScene(scene, simulator?.docked ?? null)}
          </Text>
          <Legend scene={scene} />
          <Text size="sm" c="dimmed" role="status" className="tabular">
            {placeable && hint(ghost)}
          </Text>
          <CommandErrorAlert command="Placing the robot" error={place.error} onClose={place.reset} />
        </Stack>
      )}
      <VelocityLine />
    </Section>
  );
}

/** @param ghost Where the keyboard is about to place the robot. */
function hint(ghost: Pose | null): string {
  return ghost === null
    ? "Drag the robot to another place, or by the knob before it to turn it."
    : `To be placed at ${describePose(ghost)}: Enter does it, Escape leaves it.`;
}

function Freshness({ live, known, fresh }: { live: boolean; known: boolean; fresh: boolean }) {
  if (!live) return <Badge color="gray.7">Not live</Badge>;
  if (!known) return <Badge color="gray.7">No data</Badge>;
  return fresh ? <Badge color="green">Live</Badge> : <Badge color="orange">Stale</Badge>;
}

function NoScene({ live, simulated }: { live: boolean; simulated: boolean }) {
  return (
    <Stack gap={4} data-testid="scene-words">
      <Text fw={600}>Nothing to draw yet</Text>
      <Text size="sm" c="dimmed">
        {!live && "Nothing is known before the gateway is connected."}
        {live && simulated && "The simulator is there; its first pose has not come."}
        {live && !simulated && (
          <>
            Nobody says where the robot is. A real robot does with odometry: <Code>nav_msgs/Odometry</Code> on{" "}
            <Code>odom</Code>; its dock shows up with the first detection of the marker,{" "}
            <Code>geometry_msgs/PoseStamped</Code> on <Code>detected_dock_pose</Code>. Without a robot,{" "}
            <Code>dock-gateway up</Code> starts a simulated one.
          </>
        )}
      </Text>
    </Stack>
  );
}

/** What the colours mean of what is there. */
function Legend({ scene }: { scene: Scene }) {
  const colors = SCENE_COLORS[useComputedColorScheme("light")];
  const entries = [
    { name: "trail", color: colors.trail, round: false, shown: true },
    {
      name: "contact zone",
      color: colors.contact,
      round: true,
      shown: scene.dock !== null || scene.docked !== null,
    },
    { name: "staging pose", color: colors.staging, round: false, shown: scene.staging !== null },
    { name: "marker as detected", color: colors.marker, round: true, shown: scene.marker !== null },
    { name: "infrared", color: colors.beam, round: false, shown: scene.infrared !== null },
  ];
  return (
    <ul className={classes.legend} aria-label="Legend">
      {entries
        .filter((entry) => entry.shown)
        .map(({ name, color, round }) => (
          <li key={name}>
            <span
              className={classes.swatch}
              data-round={round || undefined}
              style={{ background: color }}
              aria-hidden="true"
            />
            {name}
          </li>
        ))}
    </ul>
  );
}
