import type { PlotStackProps } from "../src/ui/PlotStack";

/** In place of the plots, which are drawn on a canvas: jsdom has none. A press on a name picks the moment 3.1 s. */
export default function PlotStack({ labels, tools, onPick }: PlotStackProps) {
  return labels.map((label, index) => (
    <div key={label}>
      <button type="button" onClick={() => onPick(3.1)}>
        {label}
      </button>
      {tools[index]}
    </div>
  ));
}
