"""The rules of latched stops."""

from datetime import UTC, datetime

from dock_gateway.latch.latches import Latch, Latches

ADA = Latch(datetime(2026, 11, 21, 3, 32, 40, 123456, UTC), "Ada")
BOB = Latch(datetime(2026, 11, 21, 4, 0, 0, 0, UTC), "Bob")


def test_a_stop_holds_for_what_is_below() -> None:
    latches = Latches({"/fleet": ADA})
    assert latches.over("/fleet/robot1/dock") == "/fleet"
    assert latches.over("/fleet2") is None
    assert latches.over("/dock") is None
    documents = latches.documents(["/", "/fleet/robot1", "/robot2", "/fleet/robot1/arm"])
    assert documents["/"] == {
        "latched": False,
        "stopped_at": None,
        "by": None,
        "robots": ["/fleet/robot1", "/fleet/robot1/arm"],
    }
    assert documents["/fleet/robot1"] == {
        "latched": True,
        "stopped_at": ADA.stopped_at,
        "by": "Ada",
        "robots": ["/fleet/robot1", "/fleet/robot1/arm"],
    }
    assert documents["/robot2"]["robots"] == []


def test_the_stop_nearest_to_the_root_counts() -> None:
    latches = Latches({"/fleet/robot1": BOB, "/": ADA})
    assert latches.over("/fleet/robot1") == "/"


def test_the_first_who_stopped_it_is_named() -> None:
    latches = Latches({"/": ADA})
    assert not latches.latch("/", BOB)
    assert not latches.latch("/", ADA)
    assert latches.held == {"/": ADA}
    assert latches.release("/")
    assert not latches.release("/")
    assert latches.held == {}


def test_an_action_of_several_robots_is_held_while_one_of_them_is() -> None:
    latches = Latches({"/robot2": ADA, "/robot1": BOB}, shared={"/fleet/undock"})
    assert latches.over("/fleet/undock") == "/robot1"
    assert latches.over("/fleet/dock") is None
    latches.release("/robot1")
    assert latches.over("/fleet/undock") == "/robot2"
    latches.release("/robot2")
    assert latches.over("/fleet/undock") is None


def test_an_action_elsewhere_is_held_with_its_robot_only() -> None:
    latches = Latches({"/hall/robot1": ADA}, homes={"/docking/dock_robot": "/hall/robot1"})
    assert latches.over("/docking/dock_robot") == "/hall/robot1"
    assert latches.over("/docking/undock_robot") is None
    latches.latch("/hall", BOB)
    latches.release("/hall/robot1")
    assert latches.over("/docking/dock_robot") == "/hall"
    latches.release("/hall")
    latches.latch("/docking", ADA)
    assert latches.over("/docking/dock_robot") is None
