"""A share covers its robots and what belongs to them, narrows every grant, and says who serves the others."""

import pytest

from dock_gateway.core.errors import ServedElsewhere
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.core.share import EVERYTHING, Claim, Share


def claim(*robots: str, claimed: bool = True) -> Claim:
    return Claim("host2", "boot2", "http://host2:8000", robots, (), "1.0.0", utc_now(), utc_now(), 1, claimed)


def test_the_actions_of_its_robots_belong_to_it_wherever_they_are() -> None:
    share = Share(["fleet_a/*", "/"], {"/docking/dock_a": "/fleet_a/robot1", "/fleet_a/x/dock_b": "/fleet_b/robot1"})
    assert share.covers("/docking/dock_a")
    assert not share.covers("/fleet_a/x/dock_b")
    assert not share.covers("/docking/dock_c")
    assert share.covers("/fleet_a/robot1/dock")
    assert share.covers("/dock")
    assert [share.covers_robot(name) for name in ("/", "/fleet_a/robot1", "/fleet_a", "/fleet_b/robot1")] == [
        True,
        True,
        False,
        False,
    ]


def test_without_patterns_it_covers_everything_and_narrows_nothing() -> None:
    assert EVERYTHING.covers("/any")
    assert EVERYTHING.covers_robot("/")
    assert EVERYTHING.narrow(UNLIMITED) is UNLIMITED


def test_a_grant_is_narrowed_in_what_moves_robots_and_not_in_what_is_read_from_the_graph() -> None:
    grant = Share(["/fleet_a/*"]).narrow(Grant(Role.OPERATOR, robots=("*/robot1",)))
    assert grant.covers_robot("/fleet_a/robot1")
    assert not grant.covers_robot("/fleet_a/robot2")
    for name in ("/fleet_b/robot1/x",):
        assert not grant.covers_action(name)
        assert not grant.covers_publishing(name)
        assert not grant.covers_service(name)
        assert not grant.covers_parameters(name)
        assert grant.covers_topic(name)
        assert grant.covers_place(name)
    assert not grant.covers_alert("/fleet_b/robot1")
    assert grant.covers_alert(None)


def test_a_narrowed_grant_is_that_of_the_same_login_and_is_not_limited() -> None:
    narrowed = Share(["/fleet_a/*"]).narrow(UNLIMITED)
    assert narrowed == UNLIMITED
    assert narrowed.own == UNLIMITED
    assert narrowed.own.share is None
    assert not narrowed.limited
    assert narrowed.fields() == {"role": Role.ADMIN, "robots": (), "actions": (), "topics": ()}


def test_the_refusal_names_the_gateway_that_has_claimed_the_robot() -> None:
    share = Share(["/fleet_a/*"])
    share.others = lambda: [claim("/fleet_c/*", claimed=False), claim("/fleet_b/*")]
    share.require_robot("/fleet_a/robot1")
    share.require("/fleet_a/robot1/dock", "the action")
    with pytest.raises(ServedElsewhere, match="the gateway at http://host2:8000 on host2 does") as refused:
        share.require_robot("/fleet_b/robot1")
    assert refused.value.problem()["gateway"] == {
        "host": "host2",
        "address": "http://host2:8000",
        "robots": ("/fleet_b/*",),
    }
    with pytest.raises(ServedElsewhere, match="no other gateway is known that does") as refused:
        share.require("/fleet_c/robot1/dock", "the action /fleet_c/robot1/dock")
    assert refused.value.problem()["gateway"] is None
