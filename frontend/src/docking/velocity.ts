import type { Twist } from "../api/types";

const number = new Intl.NumberFormat(undefined, { maximumFractionDigits: 3 });

/** A velocity command in words: `forward 0.10 m/s, turning left 0.15 rad/s`. */
export function describeVelocity(twist: Twist): string {
  const parts: string[] = [];
  const { x, y } = twist.linear;
  const turn = twist.angular.z;
  if (x === null || y === null || turn === null) return "not a number";
  if (x !== 0) parts.push(`${x > 0 ? "forward" : "backward"} ${number.format(Math.abs(x))} m/s`);
  if (y !== 0) parts.push(`${y > 0 ? "left" : "right"} ${number.format(Math.abs(y))} m/s`);
  if (turn !== 0) parts.push(`turning ${turn > 0 ? "left" : "right"} ${number.format(Math.abs(turn))} rad/s`);
  return parts.length === 0 ? "standing still" : parts.join(", ");
}
