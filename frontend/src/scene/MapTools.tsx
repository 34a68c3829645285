import type { ReactNode } from "react";
import { Tool } from "../ui/Tool";
import classes from "./scene.module.css";

const ZOOM_STEP = 1.4;

interface MapToolsProps {
  onZoom: (factor: number) => void;
  onShowAll: () => void;
  /** Before the last one. */
  children?: ReactNode;
}

/** The buttons in the corner of a map. */
export function MapTools({ onZoom, onShowAll, children }: MapToolsProps) {
  return (
    <div className={classes.tools}>
      <Tool name="Closer" onClick={() => onZoom(ZOOM_STEP)}>
        <path d="M11 5h2v6h6v2h-6v6h-2v-6H5v-2h6V5Z" />
      </Tool>
      <Tool name="Farther" onClick={() => onZoom(1 / ZOOM_STEP)}>
        <path d="M5 11h14v2H5v-2Z" />
      </Tool>
      {children}
      <Tool name="Show all" onClick={onShowAll}>
        <path d="M4 4h6v2H6v4H4V4Zm10 0h6v6h-2V6h-4V4ZM4 14h2v4h4v2H4v-6Zm14 0h2v6h-6v-2h4v-4Z" />
      </Tool>
    </div>
  );
}
