"""Which actions on the graph dock robots, and in which order of preference."""

import pytest

from dock_gateway.core.dock_adapters import charging_dock, create3, nav2
from dock_gateway.core.dock_adapters.adapter import DockAdapter
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.settings import Settings

OURS, NAV2, CREATE3 = charging_dock.DOCK, nav2.DOCK, create3.DOCK
OTHER = "some_package/action/Park"


def catalog(**settings: str) -> DockingCatalog:
    return DockingCatalog(Settings(**settings))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "types", "adapter"),
    [
        ("/connect_to_charging_dock", [OURS.action_type], OURS),
        ("/fleet/robot1/connect_to_charging_dock", [OURS.action_type], OURS),
        ("/connect_to_charging_dock", [OTHER, OURS.action_type], OURS),
        ("/connect_to_charging_dock", [OTHER], DockAdapter("dock")),
        ("/re_connect_to_charging_dock", [OURS.action_type], None),
        ("/connect_to_charging_dock/status", [OURS.action_type], None),
        ("/robot1/dock_robot", [NAV2.action_type], NAV2),
        ("/robot1/undock_robot", [nav2.UNDOCK.action_type], nav2.UNDOCK),
        ("/dock_robot", [OTHER], None),
        ("/dock", [CREATE3.action_type], CREATE3),
        ("/dock", [OTHER], None),
        ("/undock", [create3.UNDOCK.action_type], create3.UNDOCK),
    ],
)
def test_known_actions(name: str, types: list[str], adapter: DockAdapter | None) -> None:
    found = catalog().find(name, types)
    assert (None if found is None else found[0]) == adapter


def test_a_configured_action_comes_first_whatever_its_type() -> None:
    named = catalog(dock_action="park")
    assert named.find("/robot1/park", [OTHER]) == (DockAdapter("dock"), OTHER)
    assert named.find("/park", [NAV2.action_type]) == (NAV2, NAV2.action_type)
    assert named.names("dock", "/robot1") == (
        "/robot1/park",
        "/robot1/connect_to_charging_dock",
        "/robot1/dock_robot",
        "/robot1/dock",
    )
    typed = catalog(dock_action="park", dock_action_type=OTHER)
    assert typed.find("/park", [NAV2.action_type]) is None
    assert typed.preferred("dock").likely_type == OTHER


def test_a_name_or_a_type_alone_says_the_other_as_far_as_it_is_known() -> None:
    assert catalog(dock_action="dock_robot").preferred("dock").likely_type == NAV2.action_type
    assert catalog(dock_action_type=NAV2.action_type).preferred("dock").name == "dock_robot"
    assert catalog(dock_action_type=OTHER).preferred("dock").name == "connect_to_charging_dock"
    assert catalog(dock_action="park").preferred("dock").likely_type == OURS.action_type


def test_an_absolute_name_is_of_no_robot() -> None:
    shared = catalog(undock_action="/fleet/undock", namespace="/robot1")
    assert shared.names("undock")[0] == "/fleet/undock"
    assert shared.shared == {"/fleet/undock"}
    assert catalog(undock_action="fleet/undock").shared == set()
    assert shared.names("dock")[0] == "/robot1/connect_to_charging_dock"
    assert shared.robot_of("/fleet/undock", [OTHER]) is None
    assert shared.robot_of("/robot2/dock_robot", [NAV2.action_type]) == "/robot2"
    assert shared.robot_of("/dock", [CREATE3.action_type]) == "/"
    assert shared.robot_of("/dock", [OTHER]) is None
    assert catalog(dock_action="base/park").robot_of("/robot1/base/park", [OTHER]) == "/robot1"


RELAY = "/robot2/_do_not_use/dock"


def test_a_hidden_namespace_is_no_robot_unless_configured() -> None:
    assert catalog().find(RELAY, [CREATE3.action_type]) is None
    assert catalog().robot_of(RELAY, [CREATE3.action_type]) is None
    assert catalog().robot_of("/robot2/dock", [CREATE3.action_type]) == "/robot2"
    named = catalog(namespace="/robot2/_do_not_use")
    assert named.robot_of(RELAY, [CREATE3.action_type]) == "/robot2/_do_not_use"
    assert named.robot_of("/robot2/_do_not_use/arm/dock", [CREATE3.action_type]) == "/robot2/_do_not_use/arm"
    assert named.robot_of("/robot2/_do_not_use/_arm/dock", [CREATE3.action_type]) is None
    assert catalog(dock_action="_do_not_use/dock").robot_of(RELAY, [CREATE3.action_type]) == "/robot2"
    assert catalog(dock_action=RELAY).find(RELAY, [CREATE3.action_type]) == (CREATE3, CREATE3.action_type)


def test_a_shared_action_makes_no_robot_of_its_namespace() -> None:
    assert catalog(dock_action="/docking/dock_robot").robot_of("/docking/dock_robot", [NAV2.action_type]) is None


def test_actions_of_single_robots() -> None:
    ours = ("connect_to_charging_dock", "dock_robot", "dock")
    named = DockingCatalog(
        Settings.model_validate(
            {"robots": {"/robot1": {"dock_action": "/docking/dock_robot"}, "/": {"undock_action": "/base/park"}}}
        )
    )
    assert named.names("dock", "/robot1") == ("/docking/dock_robot", *(f"/robot1/{name}" for name in ours))
    assert "/docking/dock_robot" not in named.names("dock", "/docking")
    assert named.names("undock")[0] == "/base/park"
    assert named.robot_of("/docking/dock_robot", [NAV2.action_type]) == "/robot1"
    assert named.find("/docking/dock_robot", [NAV2.action_type]) == (NAV2, NAV2.action_type)
    assert named.find("/base/park", [OTHER]) == (DockAdapter("undock"), OTHER)
    assert named.robot_of("/other/dock_robot", [NAV2.action_type]) == "/other"
    assert named.place_of("/docking/dock_robot") == "/robot1/dock_robot"
    assert named.place_of("/base/park") == "/park"
    assert named.homed_in("/robot1") == {"/docking/dock_robot"}
    assert named.homed_in("/") == {"/docking/dock_robot", "/base/park"}
    assert named.is_configured("dock", "/docking/dock_robot")
    assert named.preferred("dock", "/robot1").likely_type == NAV2.action_type
    assert named.shared == set()
