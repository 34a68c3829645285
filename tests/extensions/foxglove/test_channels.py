"""Which topics a viewer is offered."""

import pytest

from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.graph import Endpoint, GraphScan, Quality, Topic
from dock_gateway.extensions.foxglove.channels import Channels

QUALITY = Quality("reliable", "volatile", "keep_last", 10, None, None, "automatic")
TYPE = "std_msgs/msg/String"


def seen(**types: str) -> GraphScan:
    """A graph in which each topic (`a__b` for /a/b) has one publisher."""
    names = {f"/{name.replace('__', '/')}": kind for name, kind in types.items()}
    return GraphScan(topics={name: Topic(name, [Endpoint("/node", kind, QUALITY)], []) for name, kind in names.items()})


async def test_topics_that_come_go_and_change_their_type() -> None:
    channels = Channels(Grant(Role.VIEWER))
    new, gone = await channels.update(seen(a=TYPE, b=TYPE, c="nothing_msgs/msg/Nothing"))
    assert ([each.topic for each in new], gone) == (["/a", "/b"], [])
    found = channels.find(new[0].id)
    assert found is not None
    assert (found.topic, "string data" in found.schema) == ("/a", True)
    again, gone = await channels.update(seen(a="std_msgs/msg/Bool"))
    assert ([each.type for each in again], {each.topic for each in gone}) == (["std_msgs/msg/Bool"], {"/a", "/b"})
    assert again[0].id != new[0].id
    assert channels.find(new[0].id) is None
    back, _ = await channels.update(seen(a=TYPE))
    assert back[0].id == new[0].id


@pytest.mark.parametrize(
    ("grant", "topics"),
    [
        (Grant(Role.VIEWER), ["/rosout", "/robot1/odom", "/robot2/odom"]),
        (Grant(Role.VIEWER, robots=("/robot1",)), ["/robot1/odom"]),
        (Grant(Role.VIEWER, topics=("*/odom",)), ["/robot1/odom", "/robot2/odom"]),
    ],
)
async def test_only_what_the_grant_includes(grant: Grant, topics: list[str]) -> None:
    graph = seen(rosout=TYPE, robot1__odom=TYPE, robot2__odom=TYPE, _hidden=TYPE, robot1__a___hidden=TYPE)
    new, _ = await Channels(grant).update(graph)
    assert sorted(each.topic for each in new) == sorted(topics)
