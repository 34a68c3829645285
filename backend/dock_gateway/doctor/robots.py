"""Checks the robots on the ROS graph: whether each of them docks, and the settings that make it. Pure."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from dock_gateway.core.battery import SURELY_TO_100, PowerSupply
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.core.filters import is_hidden, is_under, parent_of, prefix_of
from dock_gateway.core.goal import Verb
from dock_gateway.core.namespace import normalize_namespace
from dock_gateway.core.snapshot import GraphSnapshot
from dock_gateway.doctor.check import Check, Level
from dock_gateway.doctor.environment import describe_discovery
from dock_gateway.goals.hints import Sight, find_join
from dock_gateway.robots.plausibility import Plausibility
from dock_gateway.setting_groups.one_robot import describe_table
from dock_gateway.settings import Settings
from robot_io.installation import find_package_fault

COMMAND_TIMEOUT = (
    "Whether its base stops by itself when commands end cannot be seen from here: docs/stop.md says how to try it"
)


@dataclass(frozen=True)
class _Remark:
    """Something about a robot that an operator should know, and the settings that mend it."""

    level: Level
    text: str
    settings: tuple[str, ...] = ()


class RobotChecks:
    """The checks of what is on the graph.

    Args:
        settings: The settings.
        snapshot: What is on the graph.
        environment: The variables.
    """

    def __init__(self, settings: Settings, snapshot: GraphSnapshot, environment: Mapping[str, str]) -> None:
        self._settings = settings
        self._snapshot = snapshot
        self._environment = environment
        self._catalog = DockingCatalog(settings)
        self._actions: dict[Verb, dict[str, str]] = {"dock": {}, "undock": {}}
        for name, types in snapshot.actions.items():
            self._add_action(name, types)
        self._batteries: dict[str, str] = {}
        for topic in sorted(snapshot.batteries, key=self._is_unexpected):
            if not is_hidden(topic):
                self._batteries.setdefault(self._owner(topic), topic)

    def _is_unexpected(self, topic: str) -> bool:
        return self._settings.battery_of(self._owner(topic)) != topic

    def _add_action(self, name: str, types: list[str]) -> None:
        found = self._catalog.find(name, types)
        if found is None:
            return
        robot = self._catalog.robot_of(name, types) or normalize_namespace(self._settings.namespace)
        actions = self._actions[found[0].verb]
        order = self._catalog.names(found[0].verb, robot)
        if robot not in actions or order.index(name) < order.index(actions[robot]):
            actions[robot] = name

    def _owner(self, topic: str) -> str:
        """Return the robot that a battery topic belongs to."""
        docking = sorted(self._actions["dock"], key=len, reverse=True)
        for robot in docking:
            if topic == self._settings.battery_of(robot):
                return robot
        within = (robot for robot in docking if is_under(topic, robot) and (robot != "/" or parent_of(topic) == "/"))
        suffix = f"/{self._settings.battery_topic}"
        own = topic.removesuffix(suffix) or "/" if topic.endswith(suffix) else None
        return own or next(within, None) or parent_of(topic)

    def all(self) -> Iterator[Check]:
        """Yield the check of the graph, and one of each robot."""
        seen = self._snapshot
        robots = sorted({*self._actions["dock"], *self._batteries}, key=lambda robot: (len(robot), robot))
        counts = ((seen.nodes, "node"), (len(seen.actions), "action"), (len(robots), "robot"))
        texts = (f"{count} {noun}{'' if count == 1 else 's'}" for count, noun in counts)
        found = f"{', '.join(texts)} in {seen.seconds:g} s"
        if robots:
            yield Check("graph", Level.OK, found)
        else:
            yield Check("graph", Level.WARNING, f"{found}: {self._advise()}")
        for robot in robots:
            yield self._check(robot)

    def _advise(self) -> str:
        if self._snapshot.nodes:
            return "start the docking server of the robot (docs/nav2.md), or ours with `docking_server`"
        domain, discovery = self._environment.get("ROS_DOMAIN_ID") or "0", describe_discovery(self._environment)
        return f"start the robot, and see that its ROS_DOMAIN_ID is {domain} as here; {discovery}"

    def _check(self, robot: str) -> Check:
        dock, undock = self._actions["dock"].get(robot), self._actions["undock"].get(robot)
        parts = []
        if dock is not None:
            parts.append(f"docks with {dock} ({', '.join(self._snapshot.actions[dock])})")
        if undock is not None:
            parts.append(f"undocks with {undock}")
        if (battery := self._batteries.get(robot)) is not None:
            parts.append(f"battery on {battery}{self._read(robot, battery)}")
        remarks = [*self._judge_action(robot, dock), *self._judge_battery(robot, battery)]
        if dock is not None:
            remarks.append(_Remark(Level.OK, COMMAND_TIMEOUT))
        level = next((each for each in (Level.ERROR, Level.WARNING) if each in [it.level for it in remarks]), Level.OK)
        text = ". ".join(["; ".join(parts), *(each.text for each in remarks)])
        return Check(f"robot {robot}", level, text, [line for each in remarks for line in each.settings])

    def _judge_action(self, robot: str, dock: str | None) -> Iterator[_Remark]:
        if dock is None:
            join = find_join(robot, self._sights())
            advice = "start its docking server (docs/nav2.md)" if join is None else join.detail.rstrip(".")
            yield _Remark(Level.WARNING, f"No docking action: {advice}", () if join is None else tuple(join.settings))
            return
        if self._snapshot.servers.get(dock, 1) > 1 and not self._settings.allow_duplicate_servers:
            yield _Remark(
                Level.ERROR, f"{dock} has {self._snapshot.servers[dock]} servers, so it gets no goals: end one"
            )
        for action_type in self._snapshot.actions[dock]:
            package = action_type.partition("/")[0]
            if fault := find_package_fault(self._environment, [package]):
                hint = "" if "tutorials" in package else ", or `make nav2-interfaces`"
                yield _Remark(Level.ERROR, f"{fault}{hint}")

    def _sights(self) -> list[Sight]:
        robots = {*self._actions["dock"], *self._batteries}
        actions = self._actions
        return [
            Sight(robot, actions["dock"].get(robot), actions["undock"].get(robot), self._batteries.get(robot))
            for robot in sorted(robots)
        ]

    def _judge_battery(self, robot: str, battery: str | None) -> Iterator[_Remark]:
        expected = self._settings.battery_of(robot)
        if battery is None:
            yield _Remark(Level.WARNING, f"No battery: publish it on {expected}, or name its topic")
            return
        if battery != expected:
            line = self._name_battery(robot, battery)
            yield _Remark(Level.WARNING, f"The gateway looks for the battery on {expected}: set {line}", (line,))
        state = self._snapshot.batteries[battery]
        if state is None:
            yield _Remark(Level.WARNING, f"{battery} has sent nothing in {self._snapshot.seconds:g} s")
            return
        percentage, known = state["percentage"], self._settings.counts_to_100(robot)
        if isinstance(percentage, float | int) and percentage > SURELY_TO_100 and not known:
            (line,) = describe_table(robot, battery__percentage="0-100")
            yield _Remark(Level.WARNING, f"It counts percentage to 100: set {line}", (line,))
            return
        for doubt in self._plausibility(robot).judge(state, time.monotonic(), time.time()).doubts:
            yield _Remark(Level.WARNING, doubt.sentence.rstrip("."))

    def _name_battery(self, robot: str, battery: str) -> str:
        """Return the setting that names the battery topic of a robot, or of all if no one uses the default name."""
        used = any(self._settings.battery_of(each) == topic for each, topic in self._batteries.items())
        if used or not is_under(battery, robot):
            (line,) = describe_table(robot, battery__topic=battery)
            return line
        return f'battery_topic = "{battery.removeprefix(prefix_of(robot))}"'

    def _plausibility(self, robot: str) -> Plausibility:
        settings = self._settings
        return Plausibility(
            counts_to_100=settings.counts_to_100(robot), charges_negative=settings.charges_negative(robot)
        )

    def _read(self, robot: str, battery: str) -> str:
        state = self._snapshot.batteries[battery]
        if state is None:
            return ""
        reading = self._plausibility(robot).judge(state, time.monotonic(), time.time())
        charge = "" if reading.percentage is None else f" at {100 * reading.percentage:.0f} %"
        return f"{charge}, {PowerSupply(reading.power_supply).name}"


def merge_settings(checks: list[Check]) -> list[str]:
    """Return the settings of all checks, as lines of a configuration file."""
    return list(dict.fromkeys(line for check in checks for line in check.settings))
