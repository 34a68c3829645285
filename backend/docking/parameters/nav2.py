"""Reads the parameters that have other names in nav2's docking server, or other meanings here."""

from collections.abc import Callable, Iterator, Mapping

from docking.core.parameter import Meanings, Value, shown
from docking.parameters.limits import MotionLimits
from docking.parameters.nav2_table import (
    CONTROLLER,
    DOCK,
    NAV2,
    NON_CHARGING_DOCK,
    TYPE,
    Meaning,
    Nav2Parameter,
)

DIRECTIONS = {True: "backward", False: "forward"}
PLUGIN = "plugin"
PREFIXES = {"docks": DOCK, "dock_plugins": TYPE}
"""What stands for one of these names."""


def read_nav2(given: Mapping[str, Value], resolve: Callable[[str], str] = str) -> Meanings:
    """Return the meaning of given parameters that are nav2's.

    Args:
        given: The values of all parameters that are given to the node, by their names.
        resolve: The full name of a topic.

    Raises:
        ValueError: One of them would move the robot otherwise than it does here.
    """
    return _Reader(given, resolve).read()


def read_nav2_for_undocking(given: Mapping[str, Value], resolve: Callable[[str], str] = str) -> Meanings:
    """Return the meaning of parameters for the undocking server. It has no types of docks: what these agree in counts.

    Raises:
        ValueError: See `read_nav2`.
    """
    meanings = read_nav2(given, resolve)
    meanings.remarks.clear()  # they are about docking
    types = _names(given, "dock_plugins")
    meanings.notes["dock_plugins"] = ""
    for name in ("staging_x_offset", "dock_direction", "charging_source", "charging_threshold"):
        written = [f"{kind}.{name}" for kind in types]
        values = [_value(meanings, given, one) for one in written]
        for one in written:
            meanings.notes.setdefault(one, "")
        if not values or name in given or set(values) == {None}:
            continue
        if len(set(values)) == 1 and values[0] is not None:
            meanings.values[name] = values[0], written[0]
        elif name == "staging_x_offset":
            meanings.remarks.append(
                f"{', '.join(written)} differ: undocking goes by {name} until a goal has docked the robot"
            )
    return meanings


def _value(meanings: Meanings, given: Mapping[str, Value], name: str) -> Value | None:
    return given[name] if name in given else meanings.values.get(name, (None, ""))[0]


def _names(given: Mapping[str, Value], name: str) -> tuple[str, ...]:
    """The names of types or docks; none if the value is wrong, which is reported where it is declared."""
    names = given.get(name, ())
    return tuple(map(str, names)) if isinstance(names, (tuple, list)) else ()


def _switch(name: str, value: Value) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{name} is {shown(value)}, but must be true or false")
    return value


class _Reader:
    """Goes through the table once."""

    def __init__(self, given: Mapping[str, Value], resolve: Callable[[str], str]) -> None:
        self._given = given
        self._resolve = resolve
        self._types = _names(given, "dock_plugins")
        self._meanings = Meanings()
        self._special: dict[str, Callable[[str, Value], None]] = {
            "dock_backwards": self._read_direction,
            "base_frame": self._read_base_frame,
            "controller.rotate_to_heading_angular_vel": self._read_turn,
            "<type>.plugin": self._read_plugin,
            "<type>.use_battery_status": self._read_battery_status,
            "<type>.charging_threshold": self._read_threshold,
        }

    def read(self) -> Meanings:
        for parameter in NAV2:
            for name in self._written(parameter):
                if name in self._given:
                    self._read(parameter, name, self._given[name])
        self._choose_controller()
        self._compare_defaults()
        self._find_idle()
        return self._meanings

    def _written(self, parameter: Nav2Parameter) -> Iterator[str]:
        """The names that a parameter of the table has for the types and docks that there are."""
        for names, prefix in PREFIXES.items():
            if parameter.name.startswith(prefix):
                yield from (name + parameter.name[len(prefix) - 1 :] for name in _names(self._given, names))
                return
        yield parameter.name

    def _read(self, parameter: Nav2Parameter, name: str, value: Value) -> None:
        accepted = self._is_accepted(parameter, value)
        if parameter.meaning is Meaning.REFUSED and not accepted:
            raise ValueError(f"{name} is {shown(value)}, which is not possible here. {parameter.text}")
        if parameter.meaning is Meaning.IGNORED and not accepted:
            self._meanings.notes[name] = f"{name} has no effect here. {parameter.text}"
        elif parameter.meaning is not Meaning.SAME:
            self._meanings.notes[name] = ""
        if parameter.name in self._special:
            self._special[parameter.name](name, value)
        elif parameter.meaning is Meaning.MAPPED:
            self._set(parameter.ours, value, name)

    def _is_accepted(self, parameter: Nav2Parameter, value: Value) -> bool:
        """Whether it says what happens here, with any prefix of a frame and any name that means the same topic."""
        if isinstance(value, str) and parameter.name.endswith("_frame"):
            value = value.rpartition("/")[2]
        elif isinstance(value, str) and parameter.name.endswith("_topic") and value:
            return any(self._resolve(value) == self._resolve(str(one)) for one in parameter.accepted)
        return any(type(value) is type(one) and value == one for one in parameter.accepted)

    def _set(self, ours: str, value: Value, written: str) -> None:
        """Let a parameter of nav2 be the value of one of ours, unless that is given, too."""
        if self._given.get(ours, value) == value:
            self._meanings.values[ours] = value, written
        else:
            self._meanings.notes[written] = f"{written} has no effect, since {ours} is {shown(self._given[ours])}"

    def _read_direction(self, name: str, value: Value) -> None:
        direction = DIRECTIONS[_switch(name, value)]
        for other in ("dock_direction", *(f"{kind}.dock_direction" for kind in self._types)):
            if self._given.get(other, direction) != direction:
                raise ValueError(
                    f"{name} is {shown(value)}, but {other} is {shown(self._given[other])}. Leave {name} out"
                )
        self._set("dock_direction", direction, name)

    def _read_base_frame(self, name: str, value: Value) -> None:
        prefix = str(value).rpartition("/")[0].lstrip("/")
        if prefix:
            self._set("frame_prefix", f"{prefix}/", name)

    def _read_turn(self, name: str, value: Value) -> None:
        limit = self._meanings.values.get("v_angular_max", (MotionLimits().v_angular_max, ""))[0]
        limit = self._given.get("v_angular_max", limit)
        if not isinstance(value, float) or not isinstance(limit, float) or value < limit:
            self._set("v_angular_max", value, name)

    def _read_plugin(self, name: str, value: Value) -> None:
        if value == NON_CHARGING_DOCK:
            self._set_source(name, "none")

    def _read_battery_status(self, name: str, value: Value) -> None:
        self._set_source(name, "current" if _switch(name, value) else "pose")

    def _read_threshold(self, name: str, _: Value) -> None:
        source = f"{name.rpartition('.')[0]}.charging_source"
        if not {source, "charging_source"} & (self._given.keys() | self._meanings.values.keys()):
            self._set(source, "current", name)

    def _set_source(self, name: str, source: str) -> None:
        """Set what tells that the battery charges at a type of docks, unless that is given for all of them."""
        if self._given.get("charging_source", source) == source:
            self._set(f"{name.rpartition('.')[0]}.charging_source", source, name)
        else:
            self._meanings.notes[name] = (
                f"{name} has no effect, since charging_source is {shown(self._given['charging_source'])}"
            )

    def _choose_controller(self) -> None:
        """nav2's parameters are about driving to a dock that is detected, which the default controller does not do."""
        nav2 = [name for name in self._meanings.notes if name.startswith(CONTROLLER) or name == "dock_backwards"]
        nav2 += [name for name in self._meanings.notes if name.endswith(f".{PLUGIN}")]
        if nav2 and "controller" not in self._given:
            self._set("controller", "dock_pose", nav2[0])
            self._meanings.remarks.append(f"controller is not given: it is dock_pose, since nav2's {nav2[0]} is given")

    def _find_idle(self) -> None:
        """Note what has no effect without another parameter."""
        names = {"", *(f"{kind}." for kind in self._types)}
        if not self._given.get("navigate_to_staging_pose", False):
            staging = {"dock_prestaging_tolerance", "max_staging_time", "navigator_bt_xml"}
            staging |= {f"{prefix}staging_yaw_offset" for prefix in names}
            for name in staging & self._given.keys():
                if self._given[name] not in (0.0, ""):
                    self._meanings.notes[name] = f"{name} has no effect unless navigate_to_staging_pose is true"
        sources = [self._value(f"{prefix}charging_source") for prefix in names]
        if "charging_threshold" in self._given and "current" not in sources:
            self._meanings.notes["charging_threshold"] = (
                "charging_threshold has no effect unless charging_source is 'current'"
            )

    def _value(self, ours: str) -> Value | None:
        return _value(self._meanings, self._given, ours)

    def _compare_defaults(self) -> None:
        """Only for files of nav2's server, whose types of docks have plugins."""
        kinds = [kind for kind in self._types if f"{kind}.{PLUGIN}" in self._given]
        for parameter in NAV2 if kinds else ():
            for name in self._written(parameter) if parameter.differs else ():
                if name not in self._given and name.rpartition(".")[2] not in self._given:
                    default = str(parameter.default).lower()
                    self._meanings.remarks.append(
                        f"{name} is not given. With nav2 its default is {default}, here {parameter.differs}: set it"
                    )
