"""Finds the types of a robot's velocity topic. Pure: the endpoints in, the types out."""

from collections.abc import Collection

from dock_gateway.core.graph import Topic
from robot_io.velocity_types import PLAIN, STAMPED, TYPES, fitting_types


def choose_types(
    topic: Topic, before: tuple[str, ...], own: str, gateways: Collection[str] = ()
) -> tuple[tuple[str, ...], str | None]:
    """Choose the types to publish: what bases subscribe to, else what others publish, else as before.

    A node that publishes on the topic is no base, but for example another gateway. If only gateways use the
    topic with either type, and others use it with another one, it is not a topic of velocity: there is no type then.

    Args:
        topic: The endpoints of the topic.
        before: The types that are published now.
        own: Name of our node.
        gateways: Names of the nodes of gateways that matter.

    Returns:
        The types, and why they reach no base, if they do not.
    """
    talking = {endpoint.node for endpoint in topic.publishers} | {own}
    bases = {endpoint.type: endpoint.node for endpoint in topic.subscribers if endpoint.node not in talking}
    first = before[0] if before else PLAIN
    published = {endpoint.type for endpoint in topic.publishers if endpoint.node != own} & set(TYPES)
    wanted = fitting_types(bases.keys(), {min({first} & published or published or {first})})
    others = topic.types_but_of({own, *gateways})
    if others and not others & set(TYPES):
        wanted = frozenset()
    fault = None
    if bases and not bases.keys() & set(TYPES):
        kind, node = min(bases.items())
        fault = f"{topic.name} is subscribed to by {node} as {kind}, which is neither {PLAIN} nor {STAMPED}"
    return tuple(sorted(wanted, key=lambda name: (name != first, name))), fault
