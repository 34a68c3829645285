"""Each role includes the ones before it; a limited grant covers its robots, actions and topics and nothing else."""

import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.grant import SHARED_TOPICS, UNLIMITED, Grant, Role
from dock_gateway.setting_types import PATTERN

NAMES = st.lists(st.sampled_from(["robot1", "robot10", "hall_a", "dock", "x"]), max_size=3).map(
    lambda parts: "/" + "/".join(parts)
)


@pytest.mark.parametrize(
    ("role", "included"),
    [
        (Role.VIEWER, {"viewer"}),
        (Role.AGENT, {"viewer", "agent"}),
        (Role.OPERATOR, {"viewer", "agent", "operator"}),
        (Role.SUPERVISOR, {"viewer", "agent", "operator", "supervisor"}),
        (Role.ADMIN, {"viewer", "agent", "operator", "supervisor", "admin"}),
    ],
)
def test_roles_include_those_before(role: Role, included: set[str]) -> None:
    assert {each.value for each in Role if role.includes(each)} == included


def robots(*patterns: str) -> Grant:
    return Grant(Role.OPERATOR, robots=patterns)


@given(
    own=st.lists(NAMES | st.sampled_from(["/", "*/robot1", "/*"]), max_size=2).map(tuple),
    within=st.lists(NAMES | st.sampled_from(["/", "/hall_a/*"]), max_size=2).map(tuple),
    robot=NAMES,
)
def test_a_narrowed_grant_covers_what_both_do(own: tuple[str, ...], within: tuple[str, ...], robot: str) -> None:
    narrowed = robots(*own).narrowed(Role.VIEWER, within)
    assert narrowed.role is Role.VIEWER
    assert narrowed.covers_robot(robot) == (robots(*own).covers_robot(robot) and robots(*within).covers_robot(robot))
    assert narrowed.limited == bool(own or within)
    assert robots().narrowed(Role.ADMIN, ()).role is Role.OPERATOR


@pytest.mark.parametrize(
    ("patterns", "inside", "outside"),
    [
        ((), ["/", "/robot1", "/hall_a/robot1"], []),
        (("/",), ["/"], ["/robot1", "/hall_a/robot1"]),
        (("/robot1",), ["/robot1", "/robot1/arm"], ["/", "/robot10", "/hall_a/robot1", "/Robot1"]),
        (("/robot1/",), ["/robot1"], ["/robot10"]),
        (("/hall_a/*",), ["/hall_a/robot1", "/hall_a/x/arm"], ["/hall_a", "/hall_b/robot1", "/"]),
        (("/*",), ["/robot1", "/hall_a/robot1"], ["/"]),
        (("*/robot1",), ["/robot1", "/hall_a/robot1"], ["/", "/robot10", "/hall_a"]),
        (("/robot1", "/robot2"), ["/robot1", "/robot2"], ["/robot3"]),
        (("/robot.",), [], ["/robot1"]),
        (("//",), ["/"], ["/robot1", "/hall_a/robot1"]),
    ],
)
def test_robots(patterns: tuple[str, ...], inside: list[str], outside: list[str]) -> None:
    grant = robots(*patterns)
    for namespace in inside:
        assert grant.covers_robot(namespace)
        assert grant.covers_action(f"{namespace.rstrip('/')}/connect_to_charging_dock")
        assert grant.covers_topic(f"{namespace.rstrip('/')}/battery_status")
    for namespace in outside:
        assert not grant.covers_robot(namespace)
        assert not grant.covers_action(f"{namespace.rstrip('/')}/connect_to_charging_dock")
        assert not grant.covers_topic(f"{namespace.rstrip('/')}/battery_status")


@pytest.mark.parametrize(
    ("pattern", "valid"),
    [(each, True) for each in ("/", "/robot1", "/robot1/", "/hall_a/*", "/*", "/*/*", "*/dock", "*a", "**", "*_a/b*/")]
    + [(each, False) for each in ("", "*", "robot1", "//", "/a//b", "//*", "*//x", "/a//", "**//", "/robot.1", "/a\n")],
)
def test_patterns_of_names_have_no_empty_parts(pattern: str, valid: bool) -> None:
    assert (PATTERN.fullmatch(pattern) is not None) is valid


@pytest.mark.parametrize("topic", sorted(SHARED_TOPICS))
@pytest.mark.parametrize(
    ("patterns", "covered"),
    [
        ((), True),
        (("/",), False),
        (("/", "/robot1"), False),
        (("/*",), False),
        (("/", "/*"), True),
        (("**",), True),
        (("*",), True),  # of a site, for a user of its hub
        (("/robot1",), False),
    ],
)
def test_topics_of_all_robots_need_a_grant_for_all_of_them(
    topic: str, patterns: tuple[str, ...], covered: bool
) -> None:
    grant = robots(*patterns)
    assert (grant.covers_topic(topic), grant.covers_publishing(topic)) == (covered, covered)
    assert grant.covers_robot("/") is (patterns not in ((("/*",)), ("/robot1",)))
    assert not Grant(Role.VIEWER, patterns, topics=("*/odom",)).covers_topic(topic)
    assert robots(*patterns).narrowed(Role.VIEWER, ("/",)).covers_topic(topic) is False


@given(own=st.lists(NAMES | st.sampled_from(["/", "*/robot1", "/*", "**"]), max_size=2).map(tuple), robot=NAMES)
def test_who_reads_a_topic_of_all_robots_may_see_each_of_them(own: tuple[str, ...], robot: str) -> None:
    assert robots(*own).covers_robot(robot) or not robots(*own).covers_topic("/rosout")


def test_actions_and_topics_narrow_the_robots() -> None:
    grant = Grant(Role.VIEWER, ("/robot1",), ("*/undock",), ("*/battery_status", "/robot2/odom"))
    assert grant.covers_action("/robot1/undock")
    assert not grant.covers_action("/robot1/dock")
    assert not grant.covers_action("/robot2/undock")
    assert grant.covers_topic("/robot1/battery_status")
    assert not grant.covers_topic("/robot1/odom")
    assert not grant.covers_topic("/robot2/odom")
    assert grant.covers_robot("/robot1")


def test_topics_of_actions_are_limited_like_their_goals() -> None:
    grant = Grant(Role.VIEWER, actions=("*/undock",))
    assert grant.covers_topic("/robot1/undock/_action/feedback")
    assert not grant.covers_topic("/robot1/dock/_action/feedback")
    assert not grant.covers_topic("/robot1/undock/_action/feedback/_action/status")
    assert grant.covers_topic("/robot1/battery_status")


@given(
    st.text("ab/*", min_size=1, max_size=8).map(lambda text: f"/{text}"), st.text("ab/", max_size=12).map("/{}".format)
)
def test_a_star_stands_for_any_text(pattern: str, name: str) -> None:
    expected = re.fullmatch(pattern.replace("*", ".*"), name) is not None
    assert Grant(Role.VIEWER, actions=(pattern,)).covers_action(name) is expected


def test_a_long_name_is_checked_in_linear_time() -> None:
    grant = Grant(Role.OPERATOR, ("/hall_a/*/*/x*",), ("*/a*/b*/c",))
    began = time.process_time()
    assert not grant.covers_action("/hall_a" + "/" * 100_000)
    assert not grant.covers_action("/hall_a" + "/a/b" * 25_000 + "\n")
    assert time.process_time() - began < 1.0


@given(NAMES, st.lists(NAMES, min_size=1, max_size=3))
def test_a_robot_is_covered_exactly_if_it_is_or_lies_in_a_named_one(namespace: str, patterns: list[str]) -> None:
    expected = any(
        namespace == pattern or (pattern != "/" and namespace.startswith(f"{pattern}/")) for pattern in patterns
    )
    assert robots(*patterns).covers_robot(namespace) is expected


@pytest.mark.parametrize(("grant", "limited"), [(UNLIMITED, False), (robots("/a"), True), (robots(), False)])
def test_limited(grant: Grant, limited: bool) -> None:
    assert grant.limited is limited
