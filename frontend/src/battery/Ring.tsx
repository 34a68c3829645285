import type { ReactNode } from "react";
import classes from "./battery.module.css";

const SIZE = 148;
const THICKNESS = 13;
const RADIUS = (SIZE * 0.9 - 2 * THICKNESS) / 2;
const CIRCUMFERENCE = 2 * Math.PI * RADIUS;

interface RingProps {
  /** In percent; null where there is none. */
  value: number | null;
  /** A CSS colour. */
  color: string;
  /** In the middle. */
  children: ReactNode;
}

/** A value that changes often, as a ring: without transitions, which would make the browser draw every frame. */
export function Ring({ value, color, children }: RingProps) {
  const circle = { cx: SIZE / 2, cy: SIZE / 2, r: RADIUS, strokeWidth: THICKNESS, fill: "none" };
  const arc = ((value ?? 0) / 100) * CIRCUMFERENCE;
  return (
    <div className={classes.ring}>
      <svg width={SIZE} height={SIZE} viewBox={`0 0 ${SIZE} ${SIZE}`} aria-hidden="true">
        <circle {...circle} className={classes.rest} />
        {value !== null && (
          <circle
            {...circle}
            stroke={color}
            strokeLinecap="round"
            strokeDasharray={`${arc} ${CIRCUMFERENCE - arc}`}
          />
        )}
      </svg>
      <div className={classes.inside}>{children}</div>
    </div>
  );
}
