import { type Calibration, isTerminal } from "@dock-gateway/client";
import { Code, Group, Stack, Table, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useQuery } from "@tanstack/react-query";
import { useForbidden } from "../api/session";
import { NOT_CONNECTED } from "../fleet/context";
import { currentGoal } from "../goal/words";
import { useLive, useServices, useTopic } from "../store/context";
import { CopyButton } from "../ui/CopyButton";
import { Dialog, QuestionBar } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { fixed } from "../ui/numbers";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Section } from "../ui/Section";

const REFETCH_MS = 5000;
const PREFIX = "external_detection_";

/** Measures where the docked robot stands; nothing where the docking server cannot. */
export function CalibrationCard() {
  const { gateway, robot } = useServices();
  const live = useLive();
  const { data } = useQuery({
    queryKey: ["calibration", robot],
    queryFn: gateway.calibrationService,
    refetchInterval: REFETCH_MS,
    enabled: live,
  });
  const calibrate = useCommand(gateway.calibrate);
  if (data?.available !== true && calibrate.isIdle) return null;
  return (
    <Section title="Calibrate dock" help="docking#calibration">
      <Text size="sm">
        Put the robot on its dock, so that it charges. The docking server then measures where the robot
        stands, as seen from the marker, and docks it there from now on.
      </Text>
      <Start calibrate={calibrate} offered={data?.available === true} />
      <CommandErrorAlert command="Calibrate" error={calibrate.error} onClose={calibrate.reset} />
      <div role="status">{calibrate.data !== undefined && <Result calibration={calibrate.data} />}</div>
    </Section>
  );
}

interface StartProps {
  calibrate: ReturnType<typeof useCommand<Calibration>>;
  offered: boolean;
}

function Start({ calibrate, offered }: StartProps) {
  const live = useLive();
  const forbidden = useForbidden("POST /calibration");
  const goal = currentGoal(useTopic("courses"));
  const [open, question] = useDisclosure(false);
  const running = goal !== null && !isTerminal(goal.status);
  const reason = calibrate.isPending
    ? "The docking server is measuring."
    : (forbidden ??
      (!live
        ? NOT_CONNECTED
        : running
          ? "A goal is running. Wait for its end, or cancel it."
          : !offered
            ? "The docking server no longer offers calibration."
            : null));
  const start = () => {
    question.close();
    calibrate.mutate();
  };
  return (
    <Group gap="sm">
      <ReasonButton variant="default" reason={reason} aria-haspopup="dialog" onClick={question.open}>
        {calibrate.isPending ? "Calibrating…" : "Calibrate…"}
      </ReasonButton>
      <Dialog opened={open} onClose={question.close} title="Calibrate the dock?">
        <Stack gap="md">
          <Text size="sm">
            The robot must stand on its dock. It does not move, and must not be moved: measuring takes 3 to 10
            s. The new pose replaces the present one at once.
          </Text>
          <QuestionBar
            keep="Keep the present pose"
            onKeep={question.close}
            go="Calibrate"
            onGo={start}
            reason={reason}
          />
        </Stack>
      </Dialog>
    </Group>
  );
}

function Result({ calibration: { parameters, yaml } }: { calibration: Calibration }) {
  return (
    <Stack gap="sm">
      <Text size="sm" fw={600}>
        The dock is calibrated until the docking server restarts. To keep the values, write these lines into
        its parameter file.
      </Text>
      {parameters.length > 0 && (
        <Table aria-label="Measured pose">
          <Table.Thead>
            <Table.Tr>
              <Table.Th>Docked robot, from the marker</Table.Th>
              <Table.Th ta="right">Measured</Table.Th>
              <Table.Th ta="right">Before</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {parameters.map(({ name, value, before }) => (
              <Table.Tr key={name}>
                <Table.Td>{name.replace(PREFIX, "")}</Table.Td>
                <Table.Td ta="right">{numberWords(name, value)}</Table.Td>
                <Table.Td ta="right">{numberWords(name, before)}</Table.Td>
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      )}
      <Code block>{yaml}</Code>
      <div>
        <CopyButton value={yaml} what="the parameter file" />
      </div>
    </Stack>
  );
}

function numberWords(name: string, value: number): string {
  return `${fixed(value, 4)}\u00a0${name.includes("rotation") ? "rad" : "m"}`;
}
