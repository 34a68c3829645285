"""A map as a grid of cells: what is read off `nav_msgs/OccupancyGrid`. Plain data."""

import hashlib
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any

import numpy as np
import numpy.typing as npt

from dock_gateway.core.event import moment
from dock_gateway.core.frames import frame_name
from dock_gateway.core.scene import Pose

Cells = npt.NDArray[np.int8]

# The most cells of a map, and the sizes of one that are believed, in metres.
MAX_CELLS = 100_000_000
MIN_RESOLUTION, MAX_RESOLUTION = 0.001, 100.0


@dataclass(frozen=True)
class Grid:
    """A map.

    Attributes:
        cells: A row for each y, from the bottom: 0 is free, 100 occupied, a negative number unknown.
        resolution: The length of a cell's side, in metres.
        origin: The lower left corner, in the map's frame.
        frame: The name of that frame.
        stamped_at: When it was made, as the message says; None if it does not.
        revision: The same for the same map and for all readers.
    """

    cells: Cells
    resolution: float
    origin: Pose
    frame: str
    stamped_at: datetime | None
    revision: str = ""

    def signed(self) -> "Grid":
        """Return the map with its revision."""
        head = f"{self.cells.shape} {self.resolution} {self.origin} {self.frame} "
        digest = hashlib.blake2b(head.encode(), digest_size=8)
        digest.update(self.cells.data)
        return replace(self, revision=digest.hexdigest())

    def updated(self, message: Any) -> "Grid":
        """Return the map with the part that a `map_msgs/OccupancyGridUpdate` replaces.

        Raises:
            ValueError: It does not fit the map; the error says why.
        """
        rows, columns = self.cells.shape
        x, y, width, height = message.x, message.y, message.width, message.height
        if min(x, y) < 0 or x + width > columns or y + height > rows:
            raise ValueError(f"an update of {width} by {height} cells at ({x}, {y}) lies beyond {columns} by {rows}")
        cells = self.cells.copy()
        cells[y : y + height, x : x + width] = _cells(message.data, width, height)
        return replace(self, cells=cells, stamped_at=_time(message.header.stamp))

    def document(self) -> dict[str, Any]:
        """Return all but the cells for JSON."""
        height, width = self.cells.shape
        return {
            "revision": self.revision,
            "stamped_at": self.stamped_at,
            "frame": self.frame,
            "resolution": self.resolution,
            "width": width,
            "height": height,
            "origin": self.origin.document(),
        }


def read_grid(message: Any) -> Grid:
    """Return the map in a `nav_msgs/OccupancyGrid`, without a revision.

    Raises:
        ValueError: It cannot be right; the error says why.
    """
    info, turn = message.info, message.info.origin.orientation
    width, height = info.width, info.height
    if not 0 < width * height <= MAX_CELLS:
        raise ValueError(f"it has {width} by {height} cells, not 1 to {MAX_CELLS:,} of them")
    if not MIN_RESOLUTION <= info.resolution <= MAX_RESOLUTION:  # nor is a NaN
        raise ValueError(f"its cells are {info.resolution:g} m wide, not {MIN_RESOLUTION:g} to {MAX_RESOLUTION:g} m")
    try:
        position = info.origin.position
        origin = Pose.in_plane(position.x, position.y, (turn.x, turn.y, turn.z, turn.w))
    except ValueError as error:
        raise ValueError(f"of its origin, {error}") from None
    cells = _cells(message.data, width, height)
    # A float32 such as 0.05 is shown as it was meant.
    resolution = float(f"{info.resolution:.6g}")
    return Grid(cells, resolution, origin, frame_name(message.header.frame_id), _time(message.header.stamp))


def _cells(data: Any, width: int, height: int) -> Cells:
    if len(data) != width * height:
        raise ValueError(f"it has {len(data):,} values for {width} by {height} cells")
    return np.frombuffer(data, dtype=np.int8).reshape(height, width)


def _time(stamp: Any) -> datetime | None:
    nanoseconds = int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
    return moment(nanoseconds) if nanoseconds > 0 else None
