import { defaultRangeExtractor, useWindowVirtualizer } from "@tanstack/react-virtual";
import { type RefObject, useLayoutEffect, useState } from "react";

/** The height of a row with two lines (px). */
const ROW_PX = 65;

/** Up to this many rows are all on the page, where the browser's own search finds them. */
const FEW = 60;

const OVERSCAN = 12;

/**
 * The rows of a long table that are on the page: those in sight, some around them, and the one that has the focus.
 *
 * @param keys Of all rows.
 * @param focused The index of the row that has the focus; negative for none.
 */
export function useRowWindow(
  body: RefObject<HTMLTableSectionElement | null>,
  keys: readonly string[],
  focused: number,
) {
  const [top, setTop] = useState(0);
  // What is above the table may become higher at any time.
  useLayoutEffect(() => {
    if (body.current !== null) setTop(Math.round(body.current.getBoundingClientRect().top + window.scrollY));
  });
  const virtualizer = useWindowVirtualizer({
    count: keys.length,
    estimateSize: () => ROW_PX,
    measureElement: (row) => row.getBoundingClientRect().height || ROW_PX,
    getItemKey: (index) => keys[index] ?? index,
    overscan: keys.length <= FEW ? FEW : OVERSCAN,
    scrollMargin: top,
    rangeExtractor: (range) => {
      const shown = defaultRangeExtractor(range);
      return focused < 0 || shown.includes(focused) ? shown : [...shown, focused].sort((a, b) => a - b);
    },
  });
  const items = virtualizer.getVirtualItems();
  let end = top;
  const rows = items.map((item) => {
    const gap = Math.max(0, item.start - end);
    end = item.end;
    return { index: item.index, key: String(item.key), gap };
  });
  const rest = Math.max(0, virtualizer.getTotalSize() - (end - top));
  return { rows, rest, measure: virtualizer.measureElement };
}
