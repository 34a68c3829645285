"""The labels of robots at a hub: those that the robots have at their sites."""

from dock_gateway.robots.labels import NO_LABEL, RobotLabel
from dock_hub.sites import Sites


class SiteLabels:
    """The display names and groups of the robots of all sites.

    Args:
        sites: The sites, with their latest reports.
    """

    def __init__(self, sites: Sites) -> None:
        self._sites = sites

    def get(self, robot: str) -> RobotLabel:
        """Return the label of a robot; an empty one if it has none."""
        return self._all().get(robot, NO_LABEL)

    def robots(self) -> set[str]:
        """Return the robots that are known."""
        return set(self._all())

    def in_group(self, group: str) -> set[str]:
        """Return the robots that are in a group."""
        return {robot for robot, label in self._all().items() if group in label.groups}

    def _all(self) -> dict[str, RobotLabel]:
        return {
            name: RobotLabel(robot["display_name"], tuple(robot["groups"]))
            for view in self._sites.views()
            for name, robot in view.robots.items()
        }
