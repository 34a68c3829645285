import { Button, Group, Paper, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import type { StopState } from "../api/types";
import { useFleet, useFleetLive, useFleetTopic } from "../fleet/context";
import { CommandErrorAlert } from "../ui/CommandErrorAlert";
import { Dialog } from "../ui/Dialog";
import { Time } from "../ui/Time";
import { useCommand } from "../ui/useCommand";
import classes from "./stop.module.css";

/** Says that a stop holds, since when and by whom, and releases it. */
export function StopBanner() {
  const stop = useFleetTopic("stop");
  return stop.latched ? <Latched stop={stop} /> : null;
}

function Latched({ stop }: { stop: StopState }) {
  const { gateway, store } = useFleet();
  const live = useFleetLive();
  const [asking, ask] = useDisclosure(false);
  const release = useCommand(async () => {
    store.setStop(await gateway.release());
  });
  const others = stop.robots.filter((robot) => robot !== "/");

  return (
    <Paper
      component="section"
      aria-label="Stop"
      withBorder
      radius="md"
      p="md"
      className={classes.banner}
      style={{ borderColor: "var(--mantine-color-red-filled)", borderWidth: 2 }}
      data-testid="stop-banner"
    >
      <Group justify="space-between" gap="md">
        <div role="status">
          <Text fw={700} fz="lg">
            Stopped{stop.by !== null && ` by ${stop.by}`}
            {stop.since !== null && (
              <>
                {" "}
                at <Time value={stop.since} />
              </>
            )}
          </Text>
          <Text size="sm">
            {others.length > 0 && `${others.join(", ")}: `}
            Zero velocity was sent, goals are canceled, and none is sent until the stop is released.
          </Text>
        </div>
        <Button variant="default" disabled={!live} onClick={ask.open}>
          Release …
        </Button>
      </Group>
      <CommandErrorAlert command="Release" error={release.error} onClose={release.reset} />
      <Dialog opened={asking} onClose={ask.close} title="Release the stop?">
        <Stack gap="md">
          <Text size="sm">
            Goals can be sent again afterwards, by everybody. The robot stays where it is until one is. See
            first that nobody and nothing is in its way.
          </Text>
          <Group justify="flex-end" gap="sm">
            <Button variant="default" onClick={ask.close} data-autofocus>
              Keep it stopped
            </Button>
            <Button
              onClick={() => {
                ask.close();
                release.mutate();
              }}
            >
              Release
            </Button>
          </Group>
        </Stack>
      </Dialog>
    </Paper>
  );
}
