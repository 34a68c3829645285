import { Group, Paper, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { type ReactNode, useMemo, useState } from "react";
import { releasesElsewhere } from "../api/places";
import { useFleet, useFleetTopic, useNaming, useWhyNot } from "../fleet/context";
import { Dialog, QuestionBar } from "../ui/Dialog";
import { CommandErrorAlert } from "../ui/errors";
import { ReasonButton } from "../ui/ReasonButton";
import { useCommand } from "../ui/requests";
import { Time } from "../ui/Time";
import { type HeldStop, heldStops, holdsAll, isOneStop } from "./held";
import classes from "./stop.module.css";

/** Says which stops hold, since when and by whom, and releases each. */
export function StopBanner() {
  const stop = useFleetTopic("stop");
  const robots = useFleetTopic("robots");
  const held = useMemo(() => heldStops(stop, robots), [stop, robots]);
  const all = useMemo(() => holdsAll(held, robots), [held, robots]);
  const naming = useNaming();
  const [only] = held;
  if (only === undefined) return null;
  return (
    <Paper
      component="section"
      aria-label="Stop"
      withBorder
      radius="md"
      p="md"
      className={classes.banner}
      ref={tellHeight}
      data-testid="stop-banner"
    >
      {held.length === 1 ? (
        <Held stop={only} what={all ? "All robots" : naming.list(only.holds)} large>
          {all && `${naming.list(only.holds)}: `}
          Zero velocity was sent, goals are canceled, and none is sent until the stop is released.
        </Held>
      ) : (
        <Several held={held} all={all} />
      )}
    </Paper>
  );
}

/** Tells the style sheets how high the banner is: what sticks below the header sticks below it, too. */
function tellHeight(banner: HTMLElement | null) {
  if (banner === null) return;
  const root = document.documentElement.style;
  const observer = new ResizeObserver(() =>
    root.setProperty("--stop-height", `calc(${banner.offsetHeight}px + var(--mantine-spacing-xs))`),
  );
  observer.observe(banner);
  return () => {
    observer.disconnect();
    root.removeProperty("--stop-height");
  };
}

/** Several robots, each with a stop of its own: one line where they were stopped together. */
function Several({ held, all }: { held: readonly HeldStop[]; all: boolean }) {
  const naming = useNaming();
  const names = held.flatMap(({ holds }) => holds);
  const one = isOneStop(held) ? held[0] : undefined;
  return (
    <Stack gap="xs">
      <Group justify="space-between" gap="md">
        <div role="status">
          <Text fw={700} fz="lg">
            {all && "All "}
            {names.length} robots {one === undefined ? "are stopped" : <Since {...one} />}
          </Text>
          <Text size="sm">
            {naming.list(names)}: Zero velocity was sent, goals are canceled, and none is sent to a robot
            until its stop is released.
          </Text>
        </div>
        <Release held={held} />
      </Group>
      <details open={one === undefined}>
        <summary className={classes.each}>Release one at a time</summary>
        <ul className={classes.held}>
          {held.map((stop) => (
            <li key={stop.robot}>
              <Held stop={stop} what={naming.list(stop.holds)} />
            </li>
          ))}
        </ul>
      </details>
    </Stack>
  );
}

/** `stopped by Ada at 17:02:11` */
function Since({ by, since }: Pick<HeldStop, "by" | "since">) {
  return (
    <>
      stopped{by !== null && ` by ${by}`}
      {since !== null && (
        <>
          {" "}
          at <Time value={since} />
        </>
      )}
    </>
  );
}

interface HeldProps {
  stop: HeldStop;
  /** The robots that it holds. */
  what: string;
  large?: boolean;
  children?: ReactNode;
}

function Held({ stop, what, large = false, children }: HeldProps) {
  const { holds, by, since, persisted } = stop;
  const naming = useNaming();
  return (
    <Group justify="space-between" gap="md">
      <div role={large ? "status" : undefined}>
        <Text
          fw={large ? 700 : 600}
          fz={large ? "lg" : "md"}
          title={holds.map((name) => naming.fullNameOf(name)).join(", ")}
        >
          {what} <Since by={by} since={since} />
        </Text>
        <Text size="sm">{children}</Text>
        {!persisted && (
          <Text size="sm" fw={600}>
            This stop is not stored: a restart of the gateway would lose it. Check the gateway's disk.
          </Text>
        )}
      </div>
      <Release held={[stop]} small={!large} />
    </Group>
  );
}

/** Releases one stop, or all of them, after a confirmation that says whose. */
export function Release({ held, small = false }: { held: readonly HeldStop[]; small?: boolean }) {
  const { http, gateway, store } = useFleet();
  const whyNot = useWhyNot("DELETE /stop");
  const naming = useNaming();
  const [asking, ask] = useDisclosure(false);
  const [asked, setAsked] = useState(held); // a stop that comes while the question is open is not released
  const release = useCommand(async (stops: readonly HeldStop[]) => {
    const server = releasesElsewhere();
    for (const { robot } of stops)
      if (server !== null)
        await server.release(http, robot); // what holds then, the stream tells
      else store.setStop(await gateway.release(robot), robot);
  });
  const several = asked.length > 1;
  const names = asked.flatMap(({ holds }) => holds);
  return (
    <>
      <ReasonButton
        variant="default"
        size={small ? "compact-md" : "sm"}
        reason={whyNot ?? (release.isPending ? "The gateway has not answered yet." : null)}
        aria-label={small ? `Release ${naming.nameOf(held[0]?.robot ?? "/")} …` : undefined}
        onClick={() => {
          setAsked(held);
          ask.open();
        }}
      >
        {held.length > 1 ? "Release all …" : "Release …"}
      </ReasonButton>
      {release.error !== null && (
        <div className={classes.failed}>
          <CommandErrorAlert command="Release" error={release.error} onClose={release.reset} />
        </div>
      )}
      <Dialog
        opened={asking}
        onClose={ask.close}
        title={several ? `Release ${asked.length} stops?` : "Release the stop?"}
      >
        <Stack gap="md">
          <Text fw={600}>{names.map((name) => naming.fullNameOf(name)).join(", ")}</Text>
          <Text size="sm">
            Goals can be sent again afterwards, by everybody.{" "}
            {names.length > 1
              ? "The robots stay where they are until one is. Check first that their area is clear."
              : "The robot stays where it is until one is. Check first that the area is clear."}
          </Text>
          <QuestionBar
            keep={names.length > 1 ? "Keep them stopped" : "Keep it stopped"}
            onKeep={ask.close}
            go={several ? "Release all" : "Release"}
            onGo={() => {
              ask.close();
              release.mutate(asked);
            }}
          />
        </Stack>
      </Dialog>
    </>
  );
}
