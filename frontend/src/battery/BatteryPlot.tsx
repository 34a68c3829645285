import { useComputedColorScheme } from "@mantine/core";
import { useElementSize, useReducedMotion } from "@mantine/hooks";
import { useEffect, useRef } from "react";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { useServices } from "../store/context";
import classes from "./BatteryPlot.module.css";
import { PLOT_COLORS, plotOptions } from "./plotOptions";

const HEIGHT = 230;
/** uPlot's time is its redraws: ten a second for new messages, one a second to move on. */
const REDRAW_MS = 100;
const SCROLL_MS = 1000;

/** Percentage and voltage of the last five minutes. Draws outside of React. */
export function BatteryPlot() {
  const { store, series } = useServices();
  const scheme = useComputedColorScheme("light");
  const reducedMotion = useReducedMotion();
  const { ref: boxRef, width } = useElementSize<HTMLDivElement>();
  const canvasRef = useRef<HTMLDivElement>(null);

  useEffect(() => {
    if (canvasRef.current === null || width === 0) return;
    const options = plotOptions(width, HEIGHT, PLOT_COLORS[scheme], () => store.gatewayNow() / 1000);
    const plot = new uPlot(options, undefined, canvasRef.current);
    const draw = () => {
      plot.setData(series.data);
      // Without a pointer on it, the legend tells the latest values.
      if ((plot.cursor.left ?? -1) < 0 && series.length > 0) plot.setLegend({ idx: series.length - 1 });
    };
    draw();
    let drawnVersion = series.version;
    let drawnAt = Date.now();
    const timer = setInterval(
      () => {
        const idle = series.version === drawnVersion && Date.now() - drawnAt < SCROLL_MS;
        if (idle || document.hidden) return;
        drawnVersion = series.version;
        drawnAt = Date.now();
        draw();
      },
      reducedMotion ? SCROLL_MS : REDRAW_MS,
    );
    return () => {
      clearInterval(timer);
      plot.destroy();
    };
  }, [store, series, scheme, width, reducedMotion]);

  return (
    <figure className={classes.figure} ref={boxRef} data-testid="battery-plot">
      <figcaption className={classes.caption}>Last 5 minutes</figcaption>
      <div
        ref={canvasRef}
        className={classes.plot}
        role="img"
        aria-label="Percentage and voltage over time"
      />
    </figure>
  );
}
