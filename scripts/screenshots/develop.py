"""Makes an animated WebP picture of frames, with Pillow: develop.py FOLDER TARGET.

FOLDER has the frames, `0000.png` and so on, and `durations.json`: for how many ms each is shown.
"""

import json
import sys
from pathlib import Path

from PIL import Image

WIDTH = 960
QUALITY = 60
MAX_BYTES = 2_000_000


def develop(folder: Path, target: Path) -> None:
    """Make the picture. What is shown for the last time stays for two seconds."""
    durations = json.loads((folder / "durations.json").read_text())
    frames = [shrink(Image.open(path)) for path in sorted(folder.glob("*.png"))]
    durations[-1] = 2000
    first, *rest = frames
    first.save(
        target,
        save_all=True,
        append_images=rest,
        duration=durations,
        loop=0,
        quality=QUALITY,
        method=4,
        allow_mixed=True,
    )
    size = target.stat().st_size
    if size > MAX_BYTES:
        sys.exit(f"{target} has {size} bytes, more than {MAX_BYTES}")


def shrink(frame: Image.Image) -> Image.Image:
    """Return a frame as wide as the picture."""
    return frame.convert("RGB").resize((WIDTH, frame.height * WIDTH // frame.width), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    develop(Path(sys.argv[1]), Path(sys.argv[2]))
