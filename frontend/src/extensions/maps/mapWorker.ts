/** A map's picture, and the sizes in which it is wanted, the largest first. */
export interface MapJob {
  blob: Blob;
  sizes: [number, number][];
}

/** Answers with a bitmap of each size, or with null where the picture cannot be read. */
self.onmessage = async ({ data: { blob, sizes } }: MessageEvent<MapJob>) => {
  try {
    const levels: ImageBitmap[] = [];
    let source: ImageBitmapSource = blob;
    for (const [resizeWidth, resizeHeight] of sizes) {
      const level: ImageBitmap = await createImageBitmap(source, {
        resizeWidth,
        resizeHeight,
        resizeQuality: "medium",
      });
      levels.push(level);
      source = level;
    }
    self.postMessage(levels, { transfer: levels });
  } catch {
    self.postMessage(null);
  }
};
