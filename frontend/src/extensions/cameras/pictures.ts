import { type Http, settle } from "@dock-gateway/client";

/** One picture of a camera. */
export interface Picture {
  file: Blob;
  /** When the gateway received it (ms since 1970). */
  receivedAt: number;
}

/** A stream is opened again after this long without a picture, and this long after it has ended (ms). */
const SILENCE_MS = 10_000;
const RETRY_MS = 2000;
/** What stands before a picture is shorter. */
const LONGEST_HEAD = 1024;

export interface Source {
  http: Http;
  robot: string;
  /** The camera. */
  name: string;
  /** The gateway scales wider pictures down to this (pixels). */
  maxWidth: number;
}

/**
 * Hands on the pictures of a camera until the signal. The next one is read when `onPicture` is done: a slow page skips pictures.
 *
 * @param onFailure Called with each failure to open the stream, before it is tried again.
 */
export async function followCamera(
  source: Source,
  onPicture: (picture: Picture) => Promise<void>,
  onFailure: (error: unknown) => void,
  signal: AbortSignal,
): Promise<void> {
  while (!signal.aborted) {
    const silence = new AbortController();
    const arm = () => setTimeout(() => silence.abort(), SILENCE_MS);
    let timer = arm();
    try {
      for await (const picture of openPictures(source, AbortSignal.any([signal, silence.signal]))) {
        clearTimeout(timer);
        await onPicture(picture);
        timer = arm();
      }
    } catch (error) {
      if (!signal.aborted && !silence.signal.aborted) onFailure(error);
    } finally {
      clearTimeout(timer);
    }
    if (!signal.aborted) await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
  }
}

async function* openPictures(
  { http, robot, name, maxWidth }: Source,
  signal: AbortSignal,
): AsyncGenerator<Picture> {
  const params = { path: { name }, query: { robot, max_width: maxWidth } };
  const body = await settle(http.GET("/cameras/{name}/stream", { params, signal, parseAs: "stream" }));
  if (body) yield* readPictures(body as ReadableStream<Uint8Array>);
}

/** The pictures of a body of the type multipart/x-mixed-replace, whose parts say how long they are. */
export async function* readPictures(body: ReadableStream<Uint8Array>): AsyncGenerator<Picture> {
  const reader = body.getReader();
  let received: Uint8Array<ArrayBuffer> = new Uint8Array();
  try {
    for (;;) {
      const part = takePart(received);
      if (part !== null) {
        received = part.rest;
        yield part.picture;
        continue;
      }
      const { done, value } = await reader.read();
      if (done) return;
      const joined = new Uint8Array(received.length + value.length);
      joined.set(received);
      joined.set(value, received.length);
      received = joined;
    }
  } finally {
    reader.cancel().catch(() => {}); // it has ended already
  }
}

/** The first picture and what follows it; null while it has not come whole. */
function takePart(
  received: Uint8Array<ArrayBuffer>,
): { picture: Picture; rest: Uint8Array<ArrayBuffer> } | null {
  const text = new TextDecoder("latin1").decode(received.subarray(0, LONGEST_HEAD));
  const end = text.indexOf("\r\n\r\n");
  if (end < 0) {
    if (received.length < LONGEST_HEAD) return null;
    throw new Error("The stream is not one of pictures.");
  }
  const head = text.slice(0, end);
  const read = (name: string) => new RegExp(`^${name}: *(.*)$`, "im").exec(head)?.[1] ?? "";
  const start = end + 4;
  const stop = start + Number(read("content-length"));
  if (received.length < stop) return null;
  const file = new Blob([received.slice(start, stop)], { type: read("content-type") });
  return {
    picture: { file, receivedAt: 1000 * Number(read("x-timestamp")) },
    rest: received.slice(stop),
  };
}
