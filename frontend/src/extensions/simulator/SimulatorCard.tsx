import type { Simulator } from "@dock-gateway/client";
import { Group, NumberInput, SimpleGrid, Stack, Switch, Text } from "@mantine/core";
import { useState } from "react";
import { useForbidden } from "../../api/session";
import { type NumberInputValue, toNumber } from "../../battery/form";
import { useDocked } from "../../fleet/robot";
import { useLive, useServices, useTopic } from "../../store/context";
import { toRadians } from "../../store/geometry";
import { CommandErrorAlert } from "../../ui/errors";
import { ReasonButton } from "../../ui/ReasonButton";
import { useCommand } from "../../ui/requests";
import { Section } from "../../ui/Section";
import { useSimulatorAsked } from "./placing";
import { type Fault, useSimulatorApi } from "./requests";

const NOT_CONNECTED = "The simulator is out of reach while the gateway is not connected.";
const NOT_ANSWERED = "The simulator has not answered yet.";

/**
 * What can be done to a simulated robot; nothing where there is none.
 * It asks for the simulator itself: in a tab that is hidden, as that of the picture is then, no effect runs.
 */
export default function SimulatorCard() {
  useSimulatorAsked();
  const simulator = useTopic("simulator");
  return simulator === null ? null : <Controls simulator={simulator} />;
}

function Controls({ simulator }: { simulator: Simulator }) {
  const { scene } = useServices();
  const docked = useDocked();
  const api = useSimulatorApi();
  const live = useLive();
  const forbidden = useForbidden("POST /simulator/reset");
  const reset = useCommand(async () => {
    await api.reset();
    scene.trail.clear();
  });
  return (
    <Section
      title="Simulator"
      help="extensions/simulator"
      aside={<Text>{docked ? "docked" : simulator.contact ? "in contact" : "not docked"}</Text>}
    >
      <Group gap="sm">
        <ReasonButton
          variant="default"
          reason={forbidden ?? (live ? (reset.isPending ? NOT_ANSWERED : null) : NOT_CONNECTED)}
          onClick={() => reset.mutate()}
        >
          Reset
        </ReasonButton>
        <Text size="sm" c="dimmed" style={{ flex: 1 }}>
          Robot and battery as they were at the start, all faults off.
        </Text>
      </Group>
      <CommandErrorAlert command="Reset" error={reset.error} onClose={reset.reset} />
      <PlaceForm />
      <Faults simulator={simulator} />
      {simulator.battery_publisher === "other" && (
        <Text size="sm" role="status">
          Someone else publishes battery states, so the simulated battery keeps silent until they stop.
        </Text>
      )}
    </Section>
  );
}

const FIELDS = [
  { name: "x", label: "x (m)", min: -50, max: 50, step: 0.1 },
  { name: "y", label: "y (m)", min: -50, max: 50, step: 0.1 },
  { name: "heading", label: "Heading (°)", min: -180, max: 180, step: 5 },
] as const;

type Place = Record<(typeof FIELDS)[number]["name"], NumberInputValue>;

/** Places the robot by numbers, as dragging it in the picture does. */
function PlaceForm() {
  const api = useSimulatorApi();
  const live = useLive();
  const forbidden = useForbidden("POST /simulator/place");
  const [place, setPlace] = useState<Place>({ x: -1.5, y: 0.4, heading: -20 });
  const put = useCommand(api.place);
  const [x, y, heading] = FIELDS.map(({ name, min, max }) => {
    const value = toNumber(place[name]);
    return value === null || value < min || value > max ? null : value;
  });
  const valid = typeof x === "number" && typeof y === "number" && typeof heading === "number";

  return (
    <form
      aria-label="Place the robot"
      onSubmit={(event) => {
        event.preventDefault();
        if (valid && forbidden === null) put.mutate({ x, y, theta: toRadians(heading) });
      }}
    >
      <SimpleGrid cols={{ base: 2, xs: 4 }} spacing="sm" style={{ alignItems: "end" }}>
        {FIELDS.map(({ name, ...field }) => (
          <NumberInput
            key={name}
            {...field}
            decimalScale={3}
            value={place[name]}
            onChange={(value) => setPlace((before) => ({ ...before, [name]: value }))}
          />
        ))}
        <ReasonButton
          type="submit"
          variant="default"
          reason={
            forbidden ??
            (!live
              ? NOT_CONNECTED
              : !valid
                ? "One of the numbers is missing or out of range."
                : put.isPending
                  ? NOT_ANSWERED
                  : null)
          }
        >
          Place
        </ReasonButton>
      </SimpleGrid>
      <CommandErrorAlert command="Placing the robot" error={put.error} onClose={put.reset} />
    </form>
  );
}

function Faults({ simulator }: { simulator: Simulator }) {
  const api = useSimulatorApi();
  const live = useLive();
  const reason = useForbidden("PUT /simulator/faults/{fault}") ?? (live ? null : NOT_CONNECTED);
  const change = useCommand(({ fault, active }: { fault: Fault; active: boolean }) =>
    api.switchFault(fault, active),
  );
  const pending = change.isPending ? change.variables : null;
  return (
    <Stack gap="sm" role="group" aria-label="Faults">
      <SimpleGrid cols={{ base: 1, xs: 2 }} spacing="md" verticalSpacing="sm">
        {FAULTS.map(({ fault, name, effect }) => {
          const active = simulator.faults[fault] ?? false;
          return (
            <Switch
              key={fault}
              color="red"
              label={name}
              aria-label={name}
              description={effect}
              checked={pending?.fault === fault ? pending.active : active}
              disabled={reason !== null}
              wrapperProps={{ title: reason ?? undefined }}
              onChange={(event) => change.mutate({ fault, active: event.currentTarget.checked })}
            />
          );
        })}
      </SimpleGrid>
      <CommandErrorAlert command="Switching a fault" error={change.error} onClose={change.reset} />
    </Stack>
  );
}

interface FaultWords {
  fault: Fault;
  name: string;
  effect: string;
}

/** What can be made to go wrong, and what comes of it. */
const FAULTS: readonly FaultWords[] = [
  {
    fault: "dead_charger",
    name: "Dead charger",
    effect: "Contact, but no current: docking retries, then gives up with failed_to_charge.",
  },
  {
    fault: "flickering_charge",
    name: "Flickering charge",
    effect: "The charging current comes and goes: docking retries, then gives up with failed_to_charge.",
  },
  {
    fault: "dirty_contacts",
    name: "Dirty contacts",
    effect: "No current at the first contact: the robot backs a little, turns a little and presses again.",
  },
  {
    fault: "occluded_marker",
    name: "Occluded marker",
    effect: "The camera does not see the dock: failed_to_detect_dock, or lost_marker on the way.",
  },
  {
    fault: "stuck_wheel",
    name: "Stuck wheel",
    effect: "The left wheel does not turn, until the base switches its motors off: blocked.",
  },
  {
    fault: "late_commands",
    name: "Late commands",
    effect: "Commands reach the wheels 0.3 s late: docking allows for it.",
  },
  {
    fault: "lost_commands",
    name: "Lost commands",
    effect: "Three commands in ten do not reach the wheels: docking allows for it.",
  },
  {
    fault: "no_command_timeout",
    name: "No command timeout",
    effect:
      "The base keeps driving when commands end. If the docking server dies, the gateway stops the robot.",
  },
  {
    fault: "worn_wheel",
    name: "Worn wheel",
    effect:
      "The right wheel is 10 % smaller than the robot knows: it drives curves and measures straight lines.",
  },
  {
    fault: "wrong_detections",
    name: "Wrong detections",
    effect: "A third of the detections are somewhere else: docking leaves them out.",
  },
  {
    fault: "future_detections",
    name: "Future detections",
    effect: "The camera's clock is 0.5 s ahead: docking cannot use its detections, and says so.",
  },
  {
    fault: "lagging_detections",
    name: "Lagging detections",
    effect: "Detections come 0.5 s late, stamped on arrival: docking finds out how late.",
  },
  {
    fault: "frozen_camera",
    name: "Frozen camera",
    effect: "The detector repeats its last image: the robot stops, waits, and gives up.",
  },
  {
    fault: "extrapolating_camera",
    name: "Extrapolating camera",
    effect: "The detector goes on with the marker's last motion: the robot stops.",
  },
  {
    fault: "repeated_odometry",
    name: "Repeated odometry",
    effect: "Odometry repeats itself for half a second in each three: docking takes that for silence.",
  },
  {
    fault: "localization_jumps",
    name: "Localization jumps",
    effect:
      "The pose on the map jumps by 5 to 20 cm: docking without a marker stands still until that is over.",
  },
  {
    fault: "frozen_odometry",
    name: "Frozen odometry",
    effect: "Odometry repeats its last message: the robot stops, then blocked or odometry_lost.",
  },
  {
    fault: "open_loop_odometry",
    name: "Open-loop odometry",
    effect: "Odometry reports commands: where the robot is held, the marker shows it.",
  },
  {
    fault: "obstacle",
    name: "Obstacle",
    effect:
      "A pillar in front of the dock: it hides the marker, and stops the robot; with collision detection, the robot waits.",
  },
  {
    fault: "occupied_dock",
    name: "Occupied dock",
    effect:
      "Another robot stands on the dock: the robot runs into it, comes back slowly, and says where; with collision detection, it waits.",
  },
  {
    fault: "hidden_beacon",
    name: "Hidden beacon",
    effect: "No infrared receiver sees the beacon: docking by infrared waits, then backs off and retries.",
  },
  {
    fault: "frozen_beacon",
    name: "Frozen beacon",
    effect: "The infrared receivers repeat their last reading: the robot stops.",
  },
  {
    fault: "frozen_scan",
    name: "Frozen scan",
    effect: "The scanner repeats its last scan: with collision detection, the robot waits.",
  },
  {
    fault: "infrared_ghosts",
    name: "Infrared ghosts",
    effect: "A tenth of the infrared distances are random: docking leaves them out.",
  },
  {
    fault: "silent_battery",
    name: "Silent battery",
    effect: "No battery messages: the wheels stand still, and after a time battery_lost.",
  },
  {
    fault: "percentage_0_to_100",
    name: "Percentage 0 to 100",
    effect: "The battery driver counts to 100 instead of to 1, as many in the wild do.",
  },
];
