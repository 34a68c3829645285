"""All robots, or some by their namespaces and groups: what rules and webhooks apply to."""

from typing import Any


class RobotChoice:
    """A mixin of data classes that have these fields.

    Attributes:
        every_robot: Whether every robot is chosen; otherwise those of `robots` and `groups`.
        robots: Namespaces.
        groups: Groups, as `PUT /robots/label` sets them.
    """

    every_robot: bool
    robots: tuple[str, ...]
    groups: tuple[str, ...]

    def covers(self, robot: str, groups: tuple[str, ...]) -> bool:
        """Return whether a robot that is in these groups is chosen."""
        return self.every_robot or robot in self.robots or any(group in self.groups for group in groups)

    def robots_document(self) -> dict[str, Any]:
        """Return the choice as the API shows it."""
        return {"all": self.every_robot, "names": self.robots, "groups": self.groups}
