/**
 * Now, in ms since 1970, by a clock that does not jump: a computer's own is corrected while a page is open, and what waits
 * for it would wait for an hour where it goes back by one.
 */
export function steadyNow(): number {
  return performance.timeOrigin + performance.now();
}
