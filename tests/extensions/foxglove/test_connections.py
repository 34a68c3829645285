"""The connection graph that viewers are told of."""

from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.graph import Endpoint, GraphScan, Quality, Service, Topic
from dock_gateway.extensions.foxglove.connections import Connections

QUALITY = Quality("reliable", "volatile", "keep_last", 10, None, None, "automatic")


def end(node: str | None) -> Endpoint:
    return Endpoint(node, "std_msgs/msg/String", QUALITY)


def seen() -> GraphScan:
    topics = (
        Topic("/robot1/a", [end("/robot1/talker"), end(None)], [end("/listener")]),
        Topic("/robot2/a", [end("/robot2/talker")], []),
        Topic("/_hidden", [end("/talker")], []),
    )
    services = Service("/robot1/reset", ["std_srvs/srv/Trigger"], {"/robot1/talker"}), Service("/gone", [], set())
    return GraphScan(topics={each.name: each for each in topics}, services={each.name: each for each in services})


def test_what_is_there_and_what_has_changed() -> None:
    grant = Grant(Role.VIEWER, robots=("/robot1",))
    now = Connections.of(seen(), grant)
    assert now.changes_since(Connections()) == {
        "op": "connectionGraphUpdate",
        "publishedTopics": [{"name": "/robot1/a", "publisherIds": ["/robot1/talker", "?"]}],
        "subscribedTopics": [{"name": "/robot1/a", "subscriberIds": ["/listener"]}],
        "advertisedServices": [{"name": "/robot1/reset", "providerIds": ["/robot1/talker"]}],
        "removedTopics": [],
        "removedServices": [],
    }
    assert now.changes_since(now) is None
    later = seen()
    later.topics["/robot1/a"].subscribers.clear()
    update = Connections.of(later, grant).changes_since(now)
    assert update is not None
    assert update["subscribedTopics"] == [{"name": "/robot1/a", "subscriberIds": []}]
    assert (update["publishedTopics"], update["removedTopics"]) == ([], [])
    gone = Connections().changes_since(now)
    assert gone is not None
    assert (gone["removedTopics"], gone["removedServices"]) == (["/robot1/a"], ["/robot1/reset"])
