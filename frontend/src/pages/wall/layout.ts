/** A tile that is smaller cannot be read from a distance (px). */
const LEAST_WIDTH = 220;
const LEAST_HEIGHT = 120;

/** Width by height that a tile looks best with. */
const SHAPE = 1.9;

export interface Grid {
  columns: number;
  rows: number;
  pages: number;
}

/** The grid with the largest tiles for so many robots; several pages where they would be too small on one. */
export function gridFor(count: number, width: number, height: number): Grid {
  const most = Math.max(1, Math.floor(width / LEAST_WIDTH)) * Math.max(1, Math.floor(height / LEAST_HEIGHT));
  const pages = Math.max(1, Math.ceil(count / most));
  const each = Math.max(1, Math.ceil(count / pages));
  let best = { columns: 1, rows: each };
  let largest = 0;
  for (let columns = 1; columns <= each; columns += 1) {
    const rows = Math.ceil(each / columns);
    const [tileWidth, tileHeight] = [width / columns, height / rows];
    const readable = tileWidth >= LEAST_WIDTH && tileHeight >= LEAST_HEIGHT;
    const size = Math.min(tileWidth / SHAPE, tileHeight) * (readable ? 1 : 0.01);
    if (size > largest) {
      largest = size;
      best = { columns, rows };
    }
  }
  return { ...best, pages };
}
