"""Pixel by pixel: what differs between two pictures of the same page."""

import base64
from pathlib import Path
from typing import NamedTuple

from playwright.sync_api import Page

# Draws both into canvases, marks in red where a channel differs by more than 16 of 255, and counts these pixels.
COMPARE = """
async ([before, after]) => {
  const images = await Promise.all([before, after].map(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    return image;
  }));
  const width = Math.max(...images.map((image) => image.width));
  const height = Math.max(...images.map((image) => image.height));
  const [a, b] = images.map((image) => {
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, width, height);
  });
  let count = 0;
  for (let at = 0; at < a.data.length; at += 4) {
    const far = [0, 1, 2, 3].some((channel) => Math.abs(a.data[at + channel] - b.data[at + channel]) > 16);
    if (far) count += 1;
    const colour = far ? [255, 0, 0, 255] : [b.data[at], b.data[at + 1], b.data[at + 2], 60];
    b.data.set(colour, at);
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(b, 0, 0);
  const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return [count / (width * height), btoa(text)];
}
"""


class Difference(NamedTuple):
    """Two pictures of one name, and the share of pixels that differ."""

    name: str
    share: float


def compare(page: Page, before: Path, after: Path, marked: Path, tolerance: float) -> list[Difference]:
    """Compare two folders of pictures of the same names; the most different first.

    Args:
        page: An empty tab of a browser, which compares.
        before: A folder of pictures.
        after: The other one.
        marked: Where a copy of each picture goes that differs, with the differences in red.
        tolerance: The share of pixels that may differ.
    """
    marked.mkdir(parents=True, exist_ok=True)
    differences = []
    for path in sorted(after.glob("*.png")):
        pair = [base64.b64encode(file.read_bytes()).decode() for file in (before / path.name, path)]
        share, data = page.evaluate(COMPARE, pair)
        if share > tolerance:
            (marked / path.name).write_bytes(base64.b64decode(data))
            differences.append(Difference(path.name, share))
    return sorted(differences, key=lambda difference: -difference.share)
