"""Names and grants of a hub, and what they are at a site."""

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from dock_gateway.core.grant import Grant, Role
from dock_gateway.sites.names import site_grant, to_hub, to_site

# Few letters, so that patterns and names often meet.
NAMES = st.lists(st.sampled_from(["a", "b", "ab", "dock", "_action/feedback"]), min_size=1, max_size=4).map(
    lambda parts: "/" + "/".join(parts)
)
ROBOTS = st.just("/") | NAMES
PATTERNS = st.lists(
    st.text("/*ab", min_size=1, max_size=8).filter(lambda text: text[0] in "/*" and "//" not in text)
    | NAMES.map(lambda name: f"/ab{name}")
    | NAMES.map(lambda name: f"/ab{name}/*"),
    max_size=3,
).map(tuple)
GRANTS = st.builds(Grant, st.sampled_from(Role), PATTERNS, PATTERNS, PATTERNS)


@given(grant=GRANTS, robot=ROBOTS, name=NAMES)
@example(Grant(Role.VIEWER, ("/ab",)), "/", "/dock")
@example(Grant(Role.VIEWER, ("/",)), "/", "/dock")
@example(Grant(Role.VIEWER, ("/*b/a*",), ("*",), ("/a*/*",)), "/ab", "/ab")
def test_a_grant_covers_the_same_at_the_site(grant: Grant, robot: str, name: str) -> None:
    assume(not name.startswith("/_action/"))  # no action has an empty name
    site, at_hub = site_grant(grant, "ab"), to_hub("ab", name)
    if site is None:
        assert not grant.covers_robot(to_hub("ab", robot))
        assert not grant.covers_place(at_hub)
        return
    assert site.role is grant.role
    assert site.covers_robot(robot) == grant.covers_robot(to_hub("ab", robot))
    for covers in (Grant.covers_action, Grant.covers_topic, Grant.covers_service, Grant.shows, Grant.covers_publishing):
        assert covers(site, name) == covers(grant, at_hub)


@given(name=ROBOTS)
def test_a_name_comes_back(name: str) -> None:
    assert to_site("ab", to_hub("ab", name)) == name


def test_names() -> None:
    assert to_hub("berlin", "/robot1") == "/berlin/robot1"
    assert to_hub("berlin", "/") == "/berlin"
    assert to_site("berlin", "/berlin2/robot1") is None
    assert to_site("berlin", "/oslo") is None


@pytest.mark.parametrize(
    ("patterns", "at_berlin"),
    [
        ((), ()),
        (("/berlin",), ("*",)),
        (("/berlin/*",), ("/*",)),
        (("/berlin/robot1", "/oslo/robot2"), ("/robot1",)),
        (("/*/robot1",), ("*/robot1",)),
        (("/oslo", "/ber"), None),
    ],
)
def test_limits_at_a_site(patterns: tuple[str, ...], at_berlin: tuple[str, ...] | None) -> None:
    grant = site_grant(Grant(Role.OPERATOR, patterns), "berlin")
    assert (None if grant is None else grant.robots) == at_berlin
