/*
 * What changes by itself does so on common beats: a frame costs much more than what is drawn in it, so that all that is due
 * is shown in one. The browser draws no frames while the page is hidden: then nothing beats.
 */

/** From one beat to the next: fifteen a second, smooth enough for what moves, at a quarter of what every frame would cost (ms). */
export const BEAT_MS = 200 / 3;

interface Waiting {
  call: () => void;
  /** The number of beats from one call to the next. */
  every: number;
  /** The beat of the next call. */
  due: number;
}

const waiting = new Set<Waiting>();
let timer: ReturnType<typeof setTimeout> | undefined;

/** Calls `listener` every `intervalMs`, rounded to whole beats, until the returned function is called. */
export function onBeat(intervalMs: number, listener: () => void): () => void {
  const every = Math.max(1, Math.round(intervalMs / BEAT_MS));
  const one: Waiting = { call: listener, every, due: nextOf(every) };
  waiting.add(one);
  arm();
  return () => {
    waiting.delete(one);
    arm();
  };
}

/** Calls back once, on the next beat, and not before the page can be seen. Returns what takes that back. */
export function atBeat(intervalMs: number, callback: () => void): () => void {
  const cancel = onBeat(intervalMs, () => {
    cancel();
    callback();
  });
  return cancel;
}

/** Beats are counted from 1970: those of 200 ms are the moments that 200 ms divide. */
function beatNow(): number {
  return Math.floor(steadyNow() / BEAT_MS + 1e-3);
}

function nextOf(every: number): number {
  return (Math.floor(beatNow() / every) + 1) * every;
}

/** Waits for the next beat that somebody waits for. */
function arm(): void {
  clearTimeout(timer);
  if (waiting.size === 0) return;
  const due = Math.min(...[...waiting].map((one) => one.due));
  timer = setTimeout(() => requestAnimationFrame(beat), Math.ceil(due * BEAT_MS) - steadyNow());
}

function beat(): void {
  const now = beatNow();
  for (const one of [...waiting]) {
    if (one.due > now || !waiting.has(one)) continue;
    one.due = nextOf(one.every);
    one.call();
  }
  arm();
}

/**
 * Now, in ms since 1970, by a clock that does not jump: a computer's own is corrected while a page is open, and what waits
 * for it would wait for an hour where it goes back by one.
 */
export function steadyNow(): number {
  return performance.timeOrigin + performance.now();
}
