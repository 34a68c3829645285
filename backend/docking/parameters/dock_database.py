"""The docks that a robot knows by name, in nav2's form."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from docking.core.errors import DockNotInDb, DockNotValid
from docking.core.parameter import NAME, Contents, Value, file, named_groups, names, numbers, string
from docking.core.ros_yaml import entries, read_nodes, read_number, read_text
from docking.parameters.dock import DockType

KEYS = frozenset({"type", "frame", "pose", "id"})


NEAREST = "nearest"
"""The name that stands for the nearest dock, unless a dock has this name."""
MOST = 1000
"""Docks in a file."""
FARTHEST = 1e7
"""In m: no map is larger."""


def _check_pose(pose: Sequence[float]) -> None:
    if not pose:
        return
    if len(pose) != len(("x", "y", "theta")) or not all(map(math.isfinite, pose)):
        raise ValueError(f"is {list(pose)}, but must be [x, y, theta] in m and rad")
    if max(abs(pose[0]), abs(pose[1])) > FARTHEST:
        raise ValueError(f"is {list(pose)}, but x and y must be in m, from {-FARTHEST:g} to {FARTHEST:g}")
    if abs(pose[2]) > math.tau + 0.01:
        raise ValueError(f"is {list(pose)}, but theta must be in rad, from -2π to 2π: {pose[2]:g} looks like degrees")


@dataclass(frozen=True, slots=True)
class DockEntry:
    """A dock of the database."""

    type: str = string(
        "", "", "Type of the dock: one of dock_plugins. May be empty if there is at most one.", read_only=True
    )
    frame: str = string("map", "", "Frame of pose.", read_only=True)
    pose: tuple[float, ...] = numbers(
        "[x, y, theta]",
        "Pose of the docked robot in that frame, in m and rad; x points into the dock. If tf relates the frame to "
        "odometry, the marker that is detected there is the dock's, and the robot drives to where it can be seen.",
        _check_pose,
    )
    id: str = string(
        "", "", "Identifier of the dock, such as the number of its marker. For information only.", read_only=True
    )


def read_dock(location: str) -> DockEntry:
    """The dock that a goal describes instead of naming one.

    Args:
        location: A JSON object with the keys of a dock in the database: `{"frame": "map", "pose": [x, y, theta]}`.

    Raises:
        DockNotValid: It describes none.
    """
    example = '{"frame": "map", "pose": [1.0, 2.0, 1.57], "type": "wall_dock"}'
    try:
        read = json.loads(location)
    except (ValueError, RecursionError):
        raise DockNotValid(f"the dock {location!r:.80} is no JSON such as {example}") from None
    pose = read.get("pose")
    if not isinstance(pose, list) or not all(type(number) in {int, float} for number in pose) or not pose:
        raise DockNotValid(f"the dock {location!r:.80} has no pose: [x, y, theta] in m and rad, as {example}")
    texts = {key: value for key, value in read.items() if key != "pose"}
    for key, value in texts.items():
        if key not in KEYS or not isinstance(value, str):
            raise DockNotValid(f"the dock {location!r:.80} has {key!r:.20}, which is no text of {example}")
    try:
        numbers = tuple(map(float, pose))
        _check_pose(numbers)
    except OverflowError:
        raise DockNotValid(f"the dock {location!r:.80} is too far away") from None
    except ValueError as error:
        raise DockNotValid(f"the dock's pose {error}") from None
    return DockEntry(pose=numbers, **texts)


def read_file(path: str) -> Contents:
    """The parameters in a file of docks.

    Args:
        path: Of a YAML file with `docks: {home: {type: …, frame: …, pose: [x, y, theta], id: …}}`.

    Raises:
        ValueError: There is no such file, or it has something else.
    """
    try:
        return _read(read_nodes(Path(path).expanduser()))
    except OSError as error:
        raise ValueError(f"dock_database: {error}") from None
    except (ValueError, RuntimeError) as error:  # the latter for a home that is not known
        raise ValueError(f"dock_database: {path} {error}") from None


def _read(content: yaml.Node | None) -> Contents:
    file = {} if content is None else entries(content)
    docks = file.pop("docks", None)
    if not isinstance(docks, yaml.MappingNode) or not docks.value:
        raise ValueError("must have docks by name: `docks: {home: {type: …, pose: [x, y, theta]}}`")
    named = entries(docks)
    if len(named) > MOST:
        raise ValueError(f"has {len(named)} docks, but at most {MOST} are possible")
    values: dict[str, Value] = {"docks": tuple(named)}
    unknown = list(file)
    for name, dock in named.items():
        if not NAME.fullmatch(name):
            raise ValueError(f"has the dock {name!r:.80}, but a name consists of letters, digits, - and _")
        if not isinstance(dock, yaml.MappingNode):
            raise ValueError(f"has the dock {name!r}, which must have keys such as type, frame, pose and id")
        try:
            keys = entries(dock)
        except ValueError as error:
            raise ValueError(f"has the dock {name!r}, which {error}") from None
        unknown += [f"{name}.{key}" for key in keys if key not in KEYS]
        for key in sorted(KEYS & keys.keys()):
            try:
                values[f"{name}.{key}"] = _read_pose(keys[key]) if key == "pose" else read_text(keys[key])
            except ValueError as error:
                raise ValueError(f"has the dock {name!r}, whose {key} {error}") from None
    return Contents(
        values, tuple(unknown), ("docks", *(f"{name}.{key}" for name in named for key in sorted(KEYS))), "docks"
    )


def _read_pose(value: yaml.Node) -> tuple[float, ...]:
    if isinstance(value, yaml.ScalarNode) and not read_text(value):
        return ()
    parts = value.value if isinstance(value, yaml.SequenceNode) else [None]
    pose = [read_number(part.value) if isinstance(part, yaml.ScalarNode) else None for part in parts]
    numbers = tuple(number for number in pose if number is not None)
    if len(numbers) < len(pose) or not numbers:
        raise ValueError("must be [x, y, theta] in m and rad")
    _check_pose(numbers)
    return numbers


@dataclass(frozen=True, slots=True)
class DockDatabase:
    """All docks and their types. Without docks, goals may name any dock, or none."""

    dock_database: str = file(
        "path",
        "YAML file with the docks: `docks: {home: {type: …, frame: …, pose: [x, y, theta], id: …}}`. Other parameters "
        "count more than what it says.",
        read_file,
    )
    docks: tuple[str, ...] = names(
        "[home, lab]",
        "Names of the docks; the first one is meant by goals that name none. If it is empty, goals may name any dock.",
    )
    dock_plugins: tuple[str, ...] = names(
        "[wall_dock, …]",
        "Names of the types of docks. Each parameter that depends on the dock can be set for a type, with the name of "
        "the type before it: `wall_dock.staging_x_offset`.",
    )
    entries: Mapping[str, DockEntry] = named_groups(DockEntry, "docks")
    types: Mapping[str, DockType] = named_groups(DockType, "dock_plugins", inherited=True)

    def locate(self, location: str) -> tuple[str, DockEntry | None, str]:
        """The dock that a goal means: what to call it, the dock itself where it is known, and its type.

        Args:
            location: Its name, empty for the first one; or a description, see `read_dock`. The nearest dock is any one
                of the docks with a pose: which one it is depends on the robot.

        Raises:
            DockNotInDb: There is no such dock.
            DockNotValid: The description is none.
        """
        if self.is_nearest(location):
            if not self.has_poses:
                raise DockNotInDb("which dock is the nearest cannot be known: none of them has a pose")
            location = self.located[0]
        if not location.lstrip().startswith("{"):
            kind = self.type_of(location)
            found = self.entry_of(location)
            return (*found, kind) if found is not None else ("", None, kind)
        dock = read_dock(location)
        kind = dock.type or self._only_type
        if kind not in self.types and (kind or self.types):
            known = ", ".join(self.dock_plugins) or "none"
            raise DockNotValid(
                f"the type of the dock is {kind!r:.40}, but must be one of dock_plugins (there: {known})"
            )
        return f"({dock.pose[0]:.4g}, {dock.pose[1]:.4g}) in {dock.frame:.40}", dock, kind

    @property
    def _only_type(self) -> str:
        """The type of docks that have none."""
        return self.dock_plugins[0] if len(self.dock_plugins) == 1 else ""

    def type_of(self, name: str) -> str:
        """The type of the dock that a goal names; empty where there are no types.

        Args:
            name: The dock's name; empty for the first one.

        Raises:
            DockNotInDb: There is no such dock.
        """
        if self.docks and (name or self.docks[0]) not in self.entries:
            raise DockNotInDb(f"there is no dock {name!r:.80}, but: {', '.join(self.docks)}")
        return (self.entries[name or self.docks[0]].type if self.docks else "") or self._only_type

    def entry_of(self, name: str) -> tuple[str, DockEntry] | None:
        """The dock that a goal names, with its name; None where there is no such dock.

        Args:
            name: The dock's name; empty for the first one.
        """
        name = name or next(iter(self.docks), "")
        return (name, self.entries[name]) if name in self.entries else None

    def is_nearest(self, name: str) -> bool:
        """Whether a goal that names this dock means the nearest one."""
        return name == NEAREST and bool(self.docks) and name not in self.entries

    @property
    def located(self) -> tuple[str, ...]:
        """Names of the docks whose poses are known."""
        return tuple(name for name in self.docks if self.entries[name].pose)

    @property
    def has_poses(self) -> bool:
        """Whether the pose of any dock is known."""
        return bool(self.located)

    def find_fault(self) -> str | None:
        """The dock whose type is missing or unknown, as a sentence; None where there is none."""
        for name in self.docks:
            kind = self.type_of(name)
            if kind not in self.types and (kind or self.types):
                known = ", ".join(self.dock_plugins) or "none"
                return f"{name}.type is {kind!r}, but must be one of dock_plugins (there: {known})"
        return None
