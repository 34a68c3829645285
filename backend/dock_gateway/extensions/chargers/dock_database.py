"""The shared docks that have a pose as a file for docking servers: their `dock_database`, as nav2 reads it, too."""

import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml


def render(docks: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the file for docks, as `GET /shared-docks` shows them, by their names; empty if none has a pose.

    Servers know no name with a `.`, and turns of 2π at most.
    """
    placed = {name: _entry(dock) for name, dock in sorted(docks.items()) if dock["pose"] and "." not in name}
    return yaml.safe_dump({"docks": placed}, sort_keys=False, default_flow_style=None) if placed else ""


def _entry(dock: Mapping[str, Any]) -> dict[str, Any]:
    pose = dock["pose"]
    place = [float(pose["x"]), float(pose["y"]), math.remainder(pose["theta"], math.tau)]
    return ({"type": dock["type"]} if dock["type"] else {}) | {"frame": pose["frame"], "pose": place}


def write(path: Path, text: str) -> None:
    """Replace the file at once: a server never reads half of it.

    Raises:
        OSError: It cannot be written, and is what it was.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    number, fresh = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")
    try:
        with os.fdopen(number, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(number)
        Path(fresh).chmod(0o644)  # servers of other users read it
        Path(fresh).replace(path)
    except OSError:
        Path(fresh).unlink(missing_ok=True)
        raise
