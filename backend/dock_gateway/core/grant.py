"""Grants: permitted operations, and the robots, actions and topics they cover. Plain data."""

import re
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import Any, Protocol

from dock_gateway.core.errors import not_covered
from dock_gateway.core.patterns import expression, match_any, match_namespaces

# What a grant can be limited to.
LIMITS = ("robots", "actions", "topics")
# Maximum number of patterns of each limit, and of characters of one: as many as a name on the ROS graph can have.
MAX_PATTERNS, MAX_PATTERN = 50, 255
# Between the name of an action and those of its topics, `feedback` and `status`.
ACTION_TOPICS = "/_action/"
# Topics in the root whose messages are about all robots, by ROS's conventions: what all nodes log and which of their
# parameters change, the frames, the health and the time of all. They are not the robot's that has no namespace.
SHARED_TOPICS = frozenset(
    {
        "/bond",
        "/clock",
        "/diagnostics",
        "/diagnostics_agg",
        "/diagnostics_toplevel_state",
        "/parameter_events",
        "/rosout",
        "/statistics",
        "/tf",
        "/tf_static",
    }
)
# A namespace that no robot has: who may see it may see every robot in a namespace.
NO_NAMESPACE = "/\0"

# The pattern of every name.
ANY = "*"


class Role(StrEnum):
    """A role, which says what a user may do. Each includes the ones before it."""

    VIEWER = "viewer"
    AGENT = "agent"
    OPERATOR = "operator"
    SUPERVISOR = "supervisor"
    ADMIN = "admin"

    def includes(self, other: "Role") -> bool:
        """Return whether this role allows everything that the other one does."""
        roles = list(Role)
        return roles.index(self) >= roles.index(other)


class Served(Protocol):
    """The robots that a gateway serves: `core.share.Share`."""

    def covers(self, name: str) -> bool:
        """Return whether an action, or what else has a name on the ROS graph, belongs to one of them."""

    def covers_robot(self, namespace: str) -> bool:
        """Return whether a robot is one of them."""


@dataclass(frozen=True)
class Grant:
    """The permissions of a user. Patterns are names, in which `*` stands for any text.

    Attributes:
        role: Role of the user.
        robots: Patterns of the namespaces of their robots; empty means every robot. A namespace includes those below
            it, but `/` is only the robot without a namespace.
        actions: Patterns of the actions whose goals they see and send; empty means every action of their robots.
        topics: Patterns of the topics whose messages and pictures they may read; empty means every one of their robots.
        share: The robots that this gateway serves, if it leaves out any. It holds for everyone alike, and limits what
            is about robots and what may move them, not what is only read from the ROS graph.
    """

    role: Role
    robots: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()
    topics: tuple[str, ...] = ()
    share: Served | None = field(default=None, compare=False, kw_only=True)

    @property
    def limited(self) -> bool:
        """Whether it leaves out any robot or action that this gateway serves."""
        return bool(self.robots or self.actions)

    def fields(self) -> dict[str, Any]:
        """Return the role and the limits, as they are stored and shown."""
        return {"role": self.role, **{limit: getattr(self, limit) for limit in LIMITS}}

    @cached_property
    def every_robot(self) -> bool:
        """Whether it leaves out no robot, whatever its namespace."""
        return all(self._robots.fullmatch(f"{namespace}/_") for namespace in ("", NO_NAMESPACE))

    @cached_property
    def own(self) -> "Grant":
        """The user's grant at any gateway."""
        return self if self.share is None else replace(self, share=None)

    def narrowed(self, role: Role, robots: tuple[str, ...]) -> "Grant":
        """Return what both this grant and another limit allow.

        Args:
            role: The highest role.
            robots: Patterns of the namespaces of robots; empty means every robot.
        """
        lower = min(self.role, role, key=list(Role).index)
        if not self.robots or not robots:
            return replace(self, role=lower, robots=self.robots or robots)
        return NarrowedGrant(lower, self.robots, self.actions, self.topics, within=robots, share=self.share)

    @property
    def covers_every_robot(self) -> bool:
        """Whether every robot that this gateway serves is one of theirs, also one that is still to come."""
        return not self.robots or ANY in self.robots

    def covers_robot(self, namespace: str) -> bool:
        """Return whether a robot is one of theirs."""
        served = self.share is None or self.share.covers_robot(namespace)
        return served and bool(self._robots.fullmatch(f"{namespace.rstrip('/')}/_"))

    def covers_action(self, name: str) -> bool:
        """Return whether they see and send the goals of an action."""
        return self._serves(name) and bool(self._robots.fullmatch(name) and self._actions.fullmatch(name))

    def require_action(self, name: str) -> None:
        """Refuse an action that is not covered.

        Raises:
            NotAllowed: It is not (`not_allowed`).
        """
        if not self.covers_action(name):
            raise not_covered(f"the action {name[:100]}")

    def covers_topic(self, name: str) -> bool:
        """Return whether they may read a topic. Those of an action show its goals; `SHARED_TOPICS` show every robot."""
        action, of_action, _ = name.rpartition(ACTION_TOPICS)
        of_robots = self.every_robot if name in SHARED_TOPICS else self._robots.fullmatch(name)
        covered = of_robots and self._topics.fullmatch(name)
        return bool(covered and (not of_action or self._actions.fullmatch(action)))

    def shows(self, topic: str) -> bool:
        """Return whether they may see what comes with a robot from a topic, which may be one that all robots share."""
        return bool(self._topics.fullmatch(topic))

    def covers_place(self, name: str) -> bool:
        """Return whether a node or a service is in the namespace of one of their robots."""
        return bool(self._robots.fullmatch(name))

    def covers_service(self, name: str) -> bool:
        """Return whether they may call a service. It may do what any action does, so a limit to some leaves none."""
        return self._serves(name) and self.covers_place(name) and not self.actions

    def covers_publishing(self, name: str) -> bool:
        """Return whether they may publish on a topic; as for a service."""
        return self._serves(name) and self.covers_topic(name) and not self.actions

    def covers_parameters(self, node: str) -> bool:
        """Return whether they may set the parameters of a node; as for a service."""
        return self.covers_service(node)

    def covers_alert(self, robot: str | None) -> bool:
        """Return whether they see an alert of a robot; None: one of the gateway, which everyone sees."""
        return robot is None or self.covers_robot(robot)

    def _serves(self, name: str) -> bool:
        return self.share is None or self.share.covers(name)

    @cached_property
    def _robots(self) -> re.Pattern[str]:
        return match_namespaces(self.robots)

    @cached_property
    def _actions(self) -> re.Pattern[str]:
        return match_any(map(expression, self.actions))

    @cached_property
    def _topics(self) -> re.Pattern[str]:
        return match_any(map(expression, self.topics))


@dataclass(frozen=True)
class NarrowedGrant(Grant):
    """A grant with a further limit: both must cover a robot.

    Attributes:
        within: The further limit: patterns of namespaces, as in `robots`.
    """

    within: tuple[str, ...] = ()

    @property
    def covers_every_robot(self) -> bool:
        """Whether both limits cover every robot."""
        return ANY in self.robots and ANY in self.within

    @cached_property
    def _robots(self) -> re.Pattern[str]:
        both = (Grant(self.role, robots)._robots.pattern for robots in (self.within, self.robots))  # noqa: SLF001 - its own
        return re.compile("(?=(?:{})\\Z)(?:{})".format(*both), re.DOTALL)


# Someone who may do everything.
UNLIMITED = Grant(Role.ADMIN)
