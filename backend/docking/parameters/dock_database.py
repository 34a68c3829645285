"""The docks that a robot knows by name, in nav2's form."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from docking.core.errors import DockNotInDb
from docking.core.parameter import NAME, Value, file, named_groups, names, numbers, string
from docking.parameters.dock import Dock

KEYS = ("type", "frame", "pose", "id")


def _check_pose(pose: Sequence[float]) -> None:
    if pose and not (len(pose) == len(("x", "y", "theta")) and all(map(math.isfinite, pose))):
        raise ValueError(f"is {list(pose)}, but must be [x, y, theta] in m and rad")


@dataclass(frozen=True, slots=True)
class DockEntry:
    """A dock of the database."""

    type: str = string(
        "", "", "Type of the dock: one of dock_plugins. May be empty if there is at most one.", read_only=True
    )
    frame: str = string("map", "", "Frame of pose.", read_only=True)
    pose: tuple[float, ...] = numbers(
        "[x, y, theta]",
        "Pose of the docked robot in that frame, in m and rad; x points into the dock. Used if "
        "navigate_to_staging_pose is true, else for information only.",
        _check_pose,
    )
    id: str = string(
        "", "", "Identifier of the dock, such as the number of its marker. For information only.", read_only=True
    )


def read_file(path: str) -> Mapping[str, Value]:
    """The parameters in a file of docks, by their names.

    Args:
        path: Of a YAML file with `docks: {home: {type: …, frame: …, pose: [x, y, theta], id: …}}`.

    Raises:
        ValueError: There is no such file, or it has something else.
    """
    try:
        content = yaml.safe_load(Path(path).expanduser().read_text())
        return _parameters(content)
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"dock_database: {error}") from None
    except yaml.YAMLError as error:
        raise ValueError(f"dock_database: {path} is not YAML: {' '.join(str(error).split())}") from None
    except ValueError as error:
        raise ValueError(f"dock_database: {path} {error}") from None


def _parameters(content: Any) -> dict[str, Value]:
    docks = content.get("docks") if isinstance(content, dict) else None
    if not isinstance(docks, dict) or not docks:
        raise ValueError("must have docks by name: `docks: {home: {type: …, pose: [x, y, theta]}}`")
    parameters: dict[str, Value] = {"docks": tuple(map(str, docks))}
    for name, dock in docks.items():
        if not NAME.fullmatch(str(name)):
            raise ValueError(f"has the dock {name!r}, but a name consists of letters, digits, - and _")
        if not isinstance(dock, dict) or not set(dock) <= set(KEYS):
            raise ValueError(f"has the dock {name!r}, which must have no other keys than {', '.join(KEYS)}")
        for key, value in dock.items():
            parameters[f"{name}.{key}"] = _pose(name, value) if key == "pose" else str(value)
    return parameters


def _pose(name: str, value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or not all(type(number) in (int, float) for number in value):
        raise ValueError(f"has the dock {name!r}, whose pose must be [x, y, theta] in m and rad")
    return tuple(map(float, value))


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
    types: Mapping[str, Dock] = named_groups(Dock, "dock_plugins", inherited=True)

    def type_of(self, name: str) -> str:
        """The type of the dock that a goal names; empty where there are no types.

        Args:
            name: The dock's name; empty for the first one.

        Raises:
            DockNotInDb: There is no such dock.
        """
        if self.docks and (name or self.docks[0]) not in self.entries:
            raise DockNotInDb(f"there is no dock {name!r:.80}, but: {', '.join(self.docks)}")
        only = self.dock_plugins[0] if len(self.dock_plugins) == 1 else ""
        return (self.entries[name or self.docks[0]].type if self.docks else "") or only

    def entry_of(self, name: str) -> tuple[str, DockEntry] | None:
        """The dock that a goal names, with its name; None where there is no such dock.

        Args:
            name: The dock's name; empty for the first one.
        """
        name = name or next(iter(self.docks), "")
        return (name, self.entries[name]) if name in self.entries else None

    def find_fault(self) -> str | None:
        """The dock whose type is missing or unknown, as a sentence; None where there is none."""
        for name in self.docks:
            kind = self.type_of(name)
            if kind not in self.types and (kind or self.types):
                known = ", ".join(self.dock_plugins) or "none"
                return f"{name}.type is {kind!r}, but must be one of dock_plugins (there: {known})"
        return None
