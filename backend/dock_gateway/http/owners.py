"""Which robot an action belongs to, and which actions a list of goals is about."""

from collections.abc import Callable, Iterable

from dock_gateway.core.filters import lineage, parent_of
from dock_gateway.core.grant import Grant
from dock_gateway.gateway import Gateway


def owners(gateway: Gateway, action_names: Iterable[str]) -> Callable[[str], str]:
    """Return a function that names the robot of an action: the one with the longest namespace containing it.

    A namespace with a label or with goals of a docking action is a robot, too, even if it is not on the graph now.
    """
    docking = gateway.actions.docking
    gone = {
        namespace
        for name in action_names
        if docking.catalog.may_be_robot(namespace := parent_of(name)) and name in docking.all_names(namespace)
    }
    robots = gone.union(gateway.labels.robots(), (robot.namespace for robot in gateway.robots.all()))

    def owner(action_name: str) -> str:
        namespace = parent_of(docking.catalog.place_of(action_name))
        return next((each for each in reversed([*lineage(namespace)]) if each in robots), namespace)

    return owner


async def choose_actions(gateway: Gateway, grant: Grant, group: str | None) -> frozenset[str] | None:
    """Return the actions that a grant covers, and whose robots are in a group now; None if that is every action.

    Raises:
        Unavailable: The history does not answer (`history_unavailable`).
    """
    if group is None and not grant.limited:
        return None
    names = await gateway.history.action_names()
    chosen = frozenset(filter(grant.covers_action, names))
    if group is None:
        return chosen
    members, owner = gateway.labels.in_group(group), owners(gateway, names)
    return frozenset(name for name in chosen if owner(name) in members)
