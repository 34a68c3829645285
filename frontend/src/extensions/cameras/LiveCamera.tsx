import { ClientError } from "@dock-gateway/client";
import { Stack, Text } from "@mantine/core";
import { type RefObject, useEffect, useId, useRef, useState } from "react";
import { steadyNow } from "../../clock/beat";
import { useAtTime } from "../../clock/clock";
import { useFleet } from "../../fleet/context";
import { useServices } from "../../store/context";
import { Breakable } from "../../ui/Fact";
import { fixed } from "../../ui/numbers";
import { watchSight } from "../../ui/sight";
import { formatDuration } from "../../ui/time";
import classes from "./cameras.module.css";
import { followCamera, type Picture } from "./pictures";
import type { Camera } from "./requests";

const WORDS_MS = 400;
/** Without a picture for this long the last one is history (ms). */
const STALE_MS = 3000;
/** The rate is that of the last pictures in this time (ms). */
const WINDOW_MS = 3000;
/** Pictures are not asked for in fewer pixels. */
const NARROWEST = 320;
/** What has come of a camera. */
interface Seen {
  /** Since when pictures are waited for (ms, the gateway's time). */
  since: number;
  last: { receivedAt: number; width: number; height: number } | null;
  /** When the last pictures came to this page. */
  arrivals: number[];
  failure: string | null;
}

interface LiveCameraProps {
  robot: string;
  camera: Camera;
}

/** The pictures of a camera as they come. */
export default function LiveCamera({ robot, camera }: LiveCameraProps) {
  const { http } = useFleet();
  const { store } = useServices();
  const frame = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const seen = useRef<Seen>({ since: 0, last: null, arrivals: [], failure: null });
  const inSight = useInSight(frame);
  const wordsId = useId();

  useEffect(() => {
    if (!inSight) return;
    const ending = new AbortController();
    seen.current = { ...seen.current, since: store.gatewayNow(), arrivals: [], failure: null };
    const width = (frame.current?.clientWidth ?? 0) * window.devicePixelRatio;
    const source = { http, robot, name: camera.name, maxWidth: Math.max(NARROWEST, Math.ceil(1.15 * width)) };
    const onPicture = async (picture: Picture) => {
      const size = await paint(canvas.current, picture.file);
      if (ending.signal.aborted) return;
      const now = steadyNow();
      const arrivals = [...seen.current.arrivals, now].filter((at) => now - at <= WINDOW_MS);
      seen.current = {
        ...seen.current,
        last: { ...size, receivedAt: picture.receivedAt },
        arrivals,
        failure: null,
      };
    };
    const onFailure = (error: unknown) => {
      seen.current.failure = error instanceof ClientError ? error.detail : "The stream broke off.";
    };
    void followCamera(source, onPicture, onFailure, ending.signal);
    return () => ending.abort();
  }, [http, store, robot, camera.name, inSight]);

  const { hint } = camera;
  const waiting = useAtTime((now) => waitingWords(seen.current, hint, now), WORDS_MS);
  const facts = useAtTime((now) => factWords(seen.current, now, steadyNow()), WORDS_MS);
  return (
    <Stack gap="xs">
      <div className={classes.frame} ref={frame} data-stale={waiting !== "" || undefined}>
        <canvas
          ref={canvas}
          className={classes.picture}
          role="img"
          aria-label={`Camera ${camera.name}`}
          aria-describedby={wordsId}
          width={640}
          height={480}
        />
        <Text className={classes.waiting} size="sm" fw={600} role="status" id={wordsId}>
          {waiting}
        </Text>
      </div>
      <Text size="sm" c="dimmed" className="tabular">
        {facts}
        <Breakable text={camera.topic} />
      </Text>
    </Stack>
  );
}

/** Draws a picture; returns its size in pixels. */
async function paint(
  canvas: HTMLCanvasElement | null,
  file: Blob,
): Promise<{ width: number; height: number }> {
  const image = await createImageBitmap(file);
  const { width, height } = image;
  if (canvas !== null) {
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    canvas.getContext("2d")?.drawImage(image, 0, 0);
  }
  image.close();
  return { width, height };
}

/** Whether an element is in sight on a page that is. */
function useInSight(element: RefObject<HTMLElement | null>): boolean {
  const [inSight, setInSight] = useState(false);
  const [hidden, setHidden] = useState(document.hidden);
  useEffect(
    () => (element.current === null ? undefined : watchSight(element.current, setInSight)),
    [element],
  );
  useEffect(() => {
    const look = () => setHidden(document.hidden);
    document.addEventListener("visibilitychange", look);
    return () => document.removeEventListener("visibilitychange", look);
  }, []);
  return inSight && !hidden;
}

/** What is written over the picture while none comes; nothing while pictures come. */
export function waitingWords({ since, last, failure }: Seen, hint: string | null, now: number): string {
  const shown = last !== null && last.receivedAt > since - STALE_MS ? last.receivedAt : null;
  if (shown !== null && now - shown <= STALE_MS) return "";
  const why = failure ?? hint;
  if (why !== null) return why;
  if (shown === null && now - since <= STALE_MS) return "Waiting for a picture…";
  return `No picture for ${formatDuration(Math.round((now - (shown ?? since)) / 1000) * 1000).replace(/\D0(?= s$)/, "")}`;
}

/** How often pictures come, how old the last one is, and its size. */
export function factWords({ last, arrivals }: Seen, now: number, steady: number): string {
  if (last === null) return "";
  const recent = arrivals.filter((at) => steady - at <= WINDOW_MS);
  const [first] = recent;
  const hz = first === undefined ? 0 : (1000 * (recent.length - 1)) / Math.max(1, steady - first);
  return `${fixed(hz, 1)} Hz · ${formatDuration(now - last.receivedAt)} old · ${last.width} × ${last.height} · `;
}
