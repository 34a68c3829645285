import { Group, NativeSelect, Switch, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Suspense, useState } from "react";
import { useFleet } from "../../fleet/context";
import { useLive } from "../../store/context";
import { Kept, useKept } from "../../ui/kept";
import { lazyPart } from "../../ui/lazyPart";
import { Section } from "../../ui/Section";
import classes from "./cameras.module.css";
import { type Camera, listCameras } from "./requests";

const REFETCH_MS = 5000;
const LiveCamera = lazyPart(() => import("./LiveCamera"));
/** Whether this browser shows cameras: their pictures load the robot's network, so each is opened on purpose. */
const WATCHING = new Kept<boolean>(
  "dock-gateway.camera",
  (text) => text === "on",
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
  const watching = useKept(WATCHING);
  const [chosen, choose] = useState<string | null>(null);
  const camera = known.find(({ name }) => name === chosen) ?? known[0];
  if (camera === undefined) return null;
  return (
    <div className={classes.card}>
      <Section
        title="Camera"
        help="extensions/cameras#on-the-dashboard"
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
          <Text size="sm" c="dimmed">
            The camera is off: nothing is read from the robot.
          </Text>
        )}
      </Section>
    </div>
  );
}
