"""What is wrong on the ROS graph, in words."""

import pytest

from dock_gateway.core.graph import Endpoint, Quality, Topic
from dock_gateway.fleet.findings import Expected, Finding, FindingKind, merge, seen_twice, two_bases, wrong_type

QUALITY = Quality("reliable", "volatile", "keep_last", 10, None, None, "automatic")
GATEWAY, BOOL, STRING = "/dock_gateway", "std_msgs/msg/Bool", "std_msgs/msg/String"
STOP = Expected((BOOL,), "DOCK_GATEWAY_STOP_STATE_TOPIC", "It does not stop.")


def topic(*pairs: tuple[str | None, str]) -> Topic:
    return Topic("/stop_latched", [Endpoint(node, kind, QUALITY) for node, kind in pairs], [])


@pytest.mark.parametrize(
    "pairs", [[], [("/a", BOOL)], [(GATEWAY, BOOL), ("/a", BOOL)], [("/a", BOOL), (GATEWAY, STRING)]]
)
def test_a_topic_of_the_right_type_is_none(pairs: list[tuple[str, str]]) -> None:
    assert wrong_type("/", topic(*pairs), STOP, [GATEWAY]) is None


def test_it_names_the_topic_both_types_the_nodes_and_the_setting() -> None:
    found = wrong_type("/robot1", topic((GATEWAY, BOOL), ("/a", STRING), (None, STRING)), STOP, [GATEWAY])
    assert found is not None
    assert (found.robot, found.critical) == ("/robot1", True)
    for part in (
        "/stop_latched",
        BOOL,
        f"{STRING} by /a",
        "not a ROS node",
        "DOCK_GATEWAY_STOP_STATE_TOPIC",
        "not stop",
    ):
        assert part in found.detail
    mixed = wrong_type("/", topic(("/a", STRING), ("/b", BOOL)), STOP, [GATEWAY])
    assert mixed is not None
    assert not mixed.critical
    assert STOP.vital not in mixed.detail
    many = wrong_type("/", topic(*((f"/n{number}", STRING) for number in range(900))), STOP, [])
    assert many is not None
    assert "and 897 more" in many.detail


def test_findings_about_one_robot_are_one() -> None:
    kind = FindingKind.WRONG_TOPIC_TYPE
    one, two = Finding(kind, "/", "Wrong", "One."), Finding(kind, "/", "Wrong", "Two.", critical=True)
    assert list(merge([one, two, Finding(kind, "/robot1", "Wrong", "Three.")])) == [
        Finding(kind, "/", "Wrong", "One. Two.", critical=True),
        Finding(kind, "/robot1", "Wrong", "Three."),
    ]


def base(name: str, participant: str, kind: str = "geometry_msgs/msg/Twist") -> Endpoint:
    return Endpoint(name, kind, QUALITY, participant.encode().ljust(12) + b"1234")


@pytest.mark.parametrize(
    ("publishers", "subscribers", "odometry", "bases"),
    [
        ([], [("/base", "a")], [("/base", "a")], None),
        ([], [("/base", "a"), ("/base", "b")], [], "2 nodes /base"),
        ([], [("/base", "a"), ("/other", "b")], [("/base", "a"), ("/other", "b")], "/base, /other"),
        # Listeners are no bases, nor are those that drive.
        ([], [("/base", "a"), ("/recorder", "b")], [("/base", "a")], None),
        ([("/mux", "b")], [("/base", "a"), ("/mux", "b"), ("/mux", "c")], [("/base", "a")], None),
        ([], [("/base", "a"), ("/_echo", "b"), ("/_echo", "c")], [("/base", "a")], None),
        ([], [("/base", "a"), ("/base", "a")], [("/base", "a"), ("/base", "a")], None),
        ([], [("/base", "a"), ("/base", "late")], [("/base", "a")], None),
        ([], [], [("/wheels", "a"), ("/filter", "b")], "/filter, /wheels"),
    ],
)
def test_bases_of_one_robot(
    publishers: list[tuple[str, str]],
    subscribers: list[tuple[str, str]],
    odometry: list[tuple[str, str]],
    bases: str | None,
) -> None:
    velocity = Topic("/cmd_vel", [base(*each) for each in publishers], [base(*each) for each in subscribers])
    sources = Topic("/odom", [base(*each) for each in odometry], [])
    settled = {each.peer for each in (*velocity.subscribers, *sources.publishers) if not each.gid.startswith(b"late")}
    found = list(two_bases("/", velocity, sources, settled))
    assert (found[0].detail.startswith(bases) if found else None) is (None if bases is None else True)
    assert all(each.critical for each in found)


def test_one_robot_by_two_names() -> None:
    found = seen_twice({"/relay": "/relay/dock", "/robot1": "/robot1/dock"}, "/relay/node")
    assert found.robot == "/relay"
    for part in ("/relay/node", "/robot1 (/robot1/dock)", 'robots."/relay".dock_action = "/robot1/dock"'):
        assert part in found.detail
