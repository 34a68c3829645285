"""The robots that there are, with their names, at a gateway and at a hub."""

from typing import Protocol

from dock_gateway.robots.labels import RobotLabel


class RobotNames(Protocol):
    """The names of robots."""

    def namespaces(self) -> list[str]:
        """Return the namespaces of all robots, sorted."""


class Robots(RobotNames, Protocol):
    """The robots that requests may name.

    Attributes:
        default_namespace: The robot that is meant where none is named.
        own_robot: Whether that is one robot, so that a stream that names none is about it or another one.
    """

    default_namespace: str
    own_robot: bool

    def find(self, namespace: str | None = None) -> str:
        """Return the namespace of a robot as it is written in answers; default: that of the configured one.

        Raises:
            NotFound: `robot_not_found`.
        """


class RobotLabels(Protocol):
    """The display names and groups of robots."""

    def get(self, robot: str) -> RobotLabel:
        """Return the label of a robot; an empty one if it has none."""

    def robots(self) -> set[str]:
        """Return the robots that have a label."""

    def in_group(self, group: str) -> set[str]:
        """Return the robots that are in a group."""
