"""Which robot an action belongs to, and the actions of a group's robots."""

from collections.abc import Callable, Iterable

from dock_gateway.core.filters import GroupActions, lineage, parent_of
from dock_gateway.gateway import Gateway


def owners(gateway: Gateway, action_names: Iterable[str]) -> Callable[[str], str]:
    """Return a function that names the robot of an action: the one with the longest namespace containing it.

    A namespace with a label or with goals of a docking action is a robot, too, even if it is not on the graph now.
    """
    docking = gateway.settings.docking_actions
    gone = {namespace for name in action_names if name in docking(namespace := parent_of(name))}
    robots = gone.union(gateway.labels.robots(), (robot.namespace for robot in gateway.robots.all()))

    def owner(action_name: str) -> str:
        namespace = parent_of(action_name)
        return next((each for each in reversed([*lineage(namespace)]) if each in robots), namespace)

    return owner


async def actions_of_group(gateway: Gateway, group: str) -> GroupActions:
    """Return the actions of the robots that are in a group now.

    Raises:
        Unavailable: The history does not answer (`history_unavailable`).
    """
    members, names = gateway.labels.in_group(group), await gateway.history.action_names()
    owner = owners(gateway, names)
    return GroupActions(group, frozenset(name for name in names if owner(name) in members))
