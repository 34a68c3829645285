"""Two patterns of namespaces overlap exactly if a namespace can be in both."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.patterns import match_namespaces, overlap
from dock_gateway.core.share import compete

PATTERNS = st.text("ab/*", min_size=1, max_size=5).map(lambda text: f"/{text.strip('/')}")
# Every text that can be a name in a namespace, up to a length that suffices for patterns as short as these.
TEXTS = [
    f"{''.join(parts)}/_"
    for length in range(9)
    for parts in product("ab/", repeat=length)
    if length == 0 or (parts[0] == "/" and length < 8)
]


@given(PATTERNS, PATTERNS)
def test_patterns_overlap_if_a_namespace_is_in_both(one: str, other: str) -> None:
    first, second = match_namespaces([one]), match_namespaces([other])
    both = any(first.fullmatch(text) and second.fullmatch(text) for text in TEXTS)
    assert overlap(one, other) == overlap(other, one)
    if both:
        assert overlap(one, other)
    elif len(one) + len(other) <= 6:
        assert not overlap(one, other), (one, other)


@given(PATTERNS)
def test_a_pattern_overlaps_itself(pattern: str) -> None:
    assert overlap(pattern, pattern)


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ("/fleet_a/*", "/fleet_b/*", False),
        ("/fleet_a/*", "/fleet_a/robot1", True),
        ("/fleet_a", "/fleet_a/robot1", True),
        ("/fleet_a", "/fleet_ab", False),
        ("/a*", "/*b", True),
        ("/*", "/fleet_a", True),
        ("/*", "/", False),
        ("/", "/", True),
        ("/*1", "/*2", True),  # /robot1/robot2
        ("/" + "*a" * 120, "/" + "*b" * 120, True),
    ],
)
def test_robots_in_both(one: str, other: str, expected: bool) -> None:
    assert overlap(one, other) is overlap(other, one) is expected


def test_gateways_with_every_robot_are_replicas_and_none_goes_together_with_one_that_has_a_share() -> None:
    assert not compete((), ())
    assert compete((), ["/fleet_a/*"])
    assert compete(["/fleet_a/*"], ())
    assert compete(["/fleet_a/*"], ["/fleet_b/*", "/fleet_a/robot1"])
    assert not compete(["/fleet_a/*"], ["/fleet_b/*", "/"])
