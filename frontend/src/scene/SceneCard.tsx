import type { Pose, Scene, Twist } from "@dock-gateway/client";
import { isTerminal } from "@dock-gateway/client";
import { Code, Stack, Text, useComputedColorScheme } from "@mantine/core";
import { Suspense, useEffect, useId, useMemo, useState } from "react";
import { useAtTime } from "../clock/clock";
import { useDockList } from "../docking/docks";
import { Parts } from "../extension/context";
import type { Placing } from "../extension/extension";
import { FreshnessBadge } from "../fleet/badges";
import { useDocked } from "../fleet/robot";
import { currentGoal } from "../goal/words";
import { type Freshness, useFreshness, useLayers, useScene, useServices, useTopic } from "../store/context";
import { frameIn, type LegendEntry } from "../store/layers";
import type { CmdVel } from "../store/state";
import { RENDER_INTERVAL_MS } from "../store/streamStore";
import { CommandErrorAlert } from "../ui/errors";
import { lazyPart } from "../ui/lazyPart";
import { shortest } from "../ui/numbers";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";
import { lowerFirst } from "../ui/text";
import { formatDuration } from "../ui/time";
import { SCENE_COLORS, type SceneColors } from "../ui/tokens";
import type { Surroundings } from "./around";
import { type Pick, SceneCanvas } from "./SceneCanvas";
import classes from "./scene.module.css";
import { describePose, describeScene } from "./words";

/** Its code comes with the first place that is picked. */
const MapMenu = lazyPart(() => import("./MapMenu"));

/** The robot and its dock from above, in a picture and in words. */
export function SceneCard() {
  const { scene } = useServices();
  const around = useSurroundings();
  const [pick, setPick] = useState<Pick | null>();
  const freshness = useFreshness("scene");
  const [placing, setPlacing] = useState<Placing | null>(null);
  const known = useScene((scene) => scene !== null);
  const [ghost, setGhost] = useState<Pose | null>(null);
  const wordsId = useId();
  const place = useCommand(async (pose: Pose) => placing?.place(pose));
  const movable = freshness === "live" && placing !== null;
  const placeable = movable && placing.forbidden === null;

  return (
    <Section title="Map" help="dashboard#maps" aside={<FreshnessBadge freshness={freshness} />}>
      <div className={classes.over}>
        <Parts at="placing" onPlacing={setPlacing} quiet />
      </div>
      {!known ? (
        <NoScene live={freshness !== "offline"} simulated={placing !== null} />
      ) : (
        <Stack gap="xs">
          <SceneCanvas
            scene={scene}
            around={around}
            placeable={placeable}
            describedBy={wordsId}
            onPick={setPick}
            onGhost={setGhost}
            onPlace={async (pose) => {
              setGhost(null);
              // What went wrong is shown below.
              await place.mutateAsync(pose).catch(() => {});
            }}
          >
            {pick !== undefined && (
              <Suspense fallback={null}>
                <MapMenu pick={pick} onClose={() => setPick(null)} />
              </Suspense>
            )}
          </SceneCanvas>
          <MapNote />
          <Text size="sm" id={wordsId} data-testid="scene-words" className={`tabular ${classes.text}`}>
            {freshness !== "live" && "This is how it was last seen. "}
            <Words />
          </Text>
          <Legend />
          <Text size="sm" c="dimmed" role="status" className={`tabular ${classes.text}`}>
            {movable &&
              (placing.forbidden === null
                ? hint(ghost)
                : `To drag the robot: ${lowerFirst(placing.forbidden)}`)}
          </Text>
          <CommandErrorAlert command="Placing the robot" error={place.error} onClose={place.reset} />
        </Stack>
      )}
      <VelocityLine />
    </Section>
  );
}

/** What is around the robot, as its picture needs it. */
export function useSurroundings(): Surroundings {
  const { layers } = useServices();
  const docks = useDockList(useTopic("actionServer"))?.docks ?? NO_DOCKS;
  const goal = currentGoal(useTopic("courses"));
  const idle = goal === null || isTerminal(goal.status);
  const blocked = !idle && goal.stage === WAITING;
  return useMemo(
    () => ({ layers, docks, frameIn: (scene, frame) => frameIn(scene, layers, frame), blocked, idle }),
    [layers, docks, blocked, idle],
  );
}

const NO_DOCKS: [] = [];
/** The stage in which a docking server waits for an obstacle to go away. */
const WAITING = "WAIT_FOR_CLEARANCE";

/** A hint is shown when it has been true for so long (ms): before the first map and transforms have come, it is none. */
const HINT_AFTER_MS = 4000;

/** What is wrong with a layer, in a sentence. */
function MapNote() {
  const hint = useLayers((layers) => layers.flatMap((layer) => layer.hints()).join(" "));
  const [lasting, setLasting] = useState("");
  useEffect(() => {
    const timer = setTimeout(() => setLasting(hint), HINT_AFTER_MS);
    return () => clearTimeout(timer);
  }, [hint]);
  return hint === "" || hint !== lasting ? null : (
    <Text size="sm" role="status" data-testid="map-note">
      {hint}
    </Text>
  );
}

/** The picture in words, for screen readers. */
function Words() {
  const docked = useDocked();
  return useScene((scene) => (scene === null ? "" : describeScene(scene, docked)));
}

/** @param ghost Where the keyboard is about to place the robot. */
function hint(ghost: Pose | null): string {
  return ghost === null
    ? "Drag the robot to another place, or by the knob before it to turn it."
    : `To be placed at ${describePose(ghost)}: Enter does it, Escape leaves it.`;
}

function NoScene({ live, simulated }: { live: boolean; simulated: boolean }) {
  return (
    <Stack gap={4} data-testid="scene-words" className={classes.empty}>
      <Text fw={600}>Nothing to draw yet</Text>
      <Text size="sm" c="dimmed">
        {!live && "Nothing is known before the gateway is connected."}
        {live && simulated && "The simulator is there; its first pose has not come."}
        {live && !simulated && (
          <>
            No pose of the robot. A real robot tells it with odometry: <Code>nav_msgs/Odometry</Code> on{" "}
            <Code>odom</Code>; its dock shows up with the first detection of the marker,{" "}
            <Code>geometry_msgs/PoseStamped</Code> on <Code>detected_dock_pose</Code>. Without a robot,{" "}
            <Code>dock-gateway up</Code> starts a simulated one.
          </>
        )}
      </Text>
    </Stack>
  );
}

/** What is in a scene besides robot and dock. */
const SHOWN: readonly {
  name: string;
  color: keyof SceneColors;
  round?: true;
  isShown: (scene: Scene) => boolean;
}[] = [
  { name: "trail", color: "trail", isShown: () => true },
  {
    name: "contact zone",
    color: "contact",
    round: true,
    isShown: ({ dock, docked }) => dock !== null || docked !== null,
  },
  { name: "staging pose", color: "staging", isShown: ({ staging }) => staging !== null },
  { name: "marker as detected", color: "marker", round: true, isShown: ({ marker }) => marker !== null },
  { name: "infrared", color: "beam", isShown: ({ infrared }) => infrared !== null },
];

/** What the colours mean of what is there. */
function Legend() {
  const scheme = useComputedColorScheme("light");
  const { layers } = useServices();
  const entries = useScene((scene): LegendEntry[] => {
    const ofLayers = layers.flatMap((layer) => layer.legend(scheme));
    const ofScene = SHOWN.filter(({ isShown }) => scene !== null && isShown(scene)).map(
      ({ name, color, round }) => ({ name, color: SCENE_COLORS[scheme][color], ...(round && { round }) }),
    );
    return [...ofLayers, ...ofScene];
  });
  return (
    <ul className={classes.legend} aria-label="Legend">
      {entries.map(({ name, color, round }) => (
        <li key={name}>
          <span
            className={classes.swatch}
            data-round={round}
            style={{ background: color }}
            aria-hidden="true"
          />
          {name}
        </li>
      ))}
    </ul>
  );
}

/** The velocity command that the robot is given. */
function VelocityLine() {
  return (
    <Text size="sm" className="tabular" data-testid="velocity">
      <Text span size="sm" c="dimmed">
        Velocity command:
      </Text>{" "}
      <VelocityWords />
    </Text>
  );
}

function VelocityWords() {
  const { store } = useServices();
  const freshness = useFreshness("velocity");
  return useAtTime((now) => velocityWords(store.get("cmdVel"), freshness, now), RENDER_INTERVAL_MS);
}

function velocityWords({ twist, receivedAt }: CmdVel, freshness: Freshness, now: number): string {
  if (freshness === "offline") return "not live";
  if (twist === null || receivedAt === null) return "none so far";
  const words = describeVelocity(twist);
  return freshness === "live" ? words : `none for ${formatDuration(now - receivedAt)} (last: ${words})`;
}

/** A velocity command in words: `forward 0.10 m/s, turning left 0.15 rad/s`. */
export function describeVelocity(twist: Twist): string {
  const parts: string[] = [];
  const { x, y } = twist.linear;
  const turn = twist.angular.z;
  if (x === null || y === null || turn === null) return "not a number";
  if (x !== 0) parts.push(`${x > 0 ? "forward" : "backward"} ${shortest(Math.abs(x), 3)} m/s`);
  if (y !== 0) parts.push(`${y > 0 ? "left" : "right"} ${shortest(Math.abs(y), 3)} m/s`);
  if (turn !== 0) parts.push(`turning ${turn > 0 ? "left" : "right"} ${shortest(Math.abs(turn), 3)} rad/s`);
  return parts.length === 0 ? "standing still" : parts.join(", ");
}
