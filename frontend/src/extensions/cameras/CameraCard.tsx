import { Button, Group, NativeSelect, Stack, Switch, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Suspense, useState } from "react";
import { useFleet, useFleetPart } from "../../fleet/context";
import { useLive } from "../../store/context";
import { Kept, useKept } from "../../ui/kept";
import { lazyPart } from "../../ui/lazyPart";
import { Section } from "../../ui/Section";
import classes from "./cameras.module.css";
import { type Camera, listCameras } from "./requests";

const REFETCH_MS = 5000;
const LiveCamera = lazyPart(() => import("./LiveCamera"));
/**
 * Whether this browser shows cameras; null where nobody has chosen. Their pictures load the robot's network, so those of
 * a real robot are opened on purpose.
 */
const WATCHING = new Kept<boolean | null>(
  "dock-gateway.camera",
  (text) => (text === null ? null : text === "on"),
  (on) => (on ? "on" : "off"),
);

/** What the robot's cameras see; nothing where it has none. */
export function CameraCard({ robot }: { robot: string }) {
  const { http } = useFleet();
  const { data } = useQuery({
    queryKey: ["cameras", robot],
    queryFn: () => listCameras(http, robot),
    refetchInterval: REFETCH_MS,
    enabled: useLive(),
  });
  // A camera that has gone may come back: the card stays.
  const [known, setKnown] = useState<Camera[]>([]);
  if (data !== undefined && data.length > 0 && data !== known) setKnown(data);
  const simulated = useFleetPart("robots", (robots) => robots.get(robot)?.simulated ?? false);
  const watching = useKept(WATCHING) ?? simulated;
  const [chosen, choose] = useState<string | null>(null);
  const camera = known.find(({ name }) => name === chosen) ?? known[0];
  if (camera === undefined) return null;
  return (
    <div className={classes.card}>
      <Section
        title="Camera"
        aside={
          <Group gap="sm">
            {known.length > 1 && (
              <NativeSelect
                aria-label="Camera"
                size="xs"
                data={known.map(({ name }) => name)}
                value={camera.name}
                onChange={(event) => choose(event.currentTarget.value)}
              />
            )}
            <Switch
              label="Show"
              title="The gateway then subscribes to the camera, whose pictures go over the robot's network."
              labelPosition="left"
              checked={watching}
              onChange={(event) => {
                WATCHING.value = event.currentTarget.checked;
              }}
            />
          </Group>
        }
      >
        {watching ? (
          <Suspense fallback={null}>
            <LiveCamera key={camera.name} robot={robot} camera={camera} />
          </Suspense>
        ) : (
          <Stack className={classes.off} align="center" justify="center" gap="xs">
            <Text size="sm" c="dimmed" ta="center">
              The camera is off: nothing is read from the robot.
            </Text>
            <Button
              variant="default"
              size="xs"
              onClick={() => {
                WATCHING.value = true;
              }}
            >
              Show the picture
            </Button>
          </Stack>
        )}
      </Section>
    </div>
  );
}
