"""What is worth an alert, since when, and until when."""

from dataclasses import replace
from datetime import timedelta
from typing import Any

import pytest

from dock_gateway.core.battery import CHARGES_NEGATIVE
from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert import Acknowledgement, Alert, alert_id
from dock_gateway.fleet.alert_rules import AlertRules
from dock_gateway.fleet.findings import Finding, FindingKind
from dock_gateway.fleet.robot_state import RobotState
from dock_gateway.storage import Incident
from tests.support.robot_states import CHARGING, DISCHARGING, FULL, NOON, NOT_CHARGING, UNKNOWN, WRONG, goal, robot


class Looks:
    """Looks at robots at a number of seconds past noon."""

    def __init__(self, low_battery: float = 0.2) -> None:
        self._watch = AlertRules(low_battery)

    def alerts(self, seconds: float, *robots: RobotState, strays: tuple[Goal, ...] = ()) -> list[Alert]:
        return self._watch.evaluate(list(robots), strays, NOON + timedelta(seconds=seconds), 1000 + seconds)

    def kinds(self, seconds: float, *robots: RobotState) -> list[str]:
        return [alert.kind.value for alert in self.alerts(seconds, *robots)]


def test_a_robot_that_is_well() -> None:
    looks = Looks()
    for supply, docked in ((DISCHARGING, None), (CHARGING, True), (FULL, True)):
        well = robot(supply=supply, left_docked=docked)
        assert looks.kinds(0, well) == looks.kinds(60, well) == []


def test_one_alert_for_a_stop_of_all() -> None:
    stopped = [robot(name, latched=True) for name in ("/", "/robot1", "/robot1/arm")]
    (alert,) = Looks().alerts(0, *stopped)
    assert (alert.kind, alert.robot, alert.started_at) == (alert_kinds.STOP_LATCHED, "/", NOON)
    assert alert.detail.startswith("Ada stopped / and 2 below it")
    separate = Looks().alerts(0, robot("/"), robot("/robot1", latched=True), robot("/robot10", latched=True))
    assert {alert.robot for alert in separate} == {"/robot1", "/robot10"}


def test_a_lost_goal_for_an_hour_at_most() -> None:
    lost = goal("/robot1/dock", GoalStatus.LOST)
    lost.error = GoalError("action_server_lost", "the action server left the ROS graph")
    (alert,) = Looks().alerts(1, robot(lost=[lost]))
    assert (alert.kind, alert.goal_id, alert.started_at) == (alert_kinds.GOAL_LOST, "a", NOON)
    assert "the action server left the ROS graph" in alert.detail
    assert Looks().alerts(3601, robot(lost=[lost])) == []
    (stray,) = Looks().alerts(1, strays=(goal("/fibonacci", GoalStatus.LOST),))
    assert stray.robot == "/"


def test_a_lost_goal_that_a_relay_passed_on_is_one_alert() -> None:
    seen, passed_on = goal("/robot1/dock", GoalStatus.LOST), goal("/robot1/_base/dock", GoalStatus.LOST)
    (alert,) = Looks().alerts(1, robot(lost=[passed_on, seen]))
    assert "/robot1/dock" in alert.detail
    (alone,) = Looks().alerts(1, robot(lost=[passed_on]))
    assert "/robot1/_base/dock" in alone.detail


@pytest.mark.parametrize(
    "docked",
    [
        {"left_docked": True},
        {"contact": True},
        {"left_docked": True, "supply": NOT_CHARGING, "percentage": None},
    ],
)
def test_a_docked_robot_without_power(docked: dict[str, Any]) -> None:
    looks = Looks()
    assert looks.kinds(0, robot(**docked)) == looks.kinds(9.9, robot(**docked)) == []
    (alert,) = looks.alerts(10, robot(**docked))
    assert (alert.kind, alert.started_at) == (alert_kinds.DISCHARGING_ON_DOCK, NOON)
    assert looks.kinds(11, robot(supply=CHARGING, left_docked=True)) == []
    assert looks.kinds(12, robot(**docked)) == []  # it begins anew


@pytest.mark.parametrize(
    "excuse",
    [
        {"left_docked": False},
        {"left_docked": True, "percentage": 0.995},
        {"left_docked": True, "goals": [goal("/robot1/undock")]},
        {"left_docked": True, "goals": [goal("/robot1/dock")]},
        {"contact": False},
    ],
)
def test_a_robot_that_need_not_be_charged(excuse: dict[str, Any]) -> None:
    looks = Looks()
    assert looks.kinds(0, robot(**excuse)) == looks.kinds(60, robot(**excuse)) == []


def test_a_low_battery_until_it_is_well_above() -> None:
    looks = Looks()
    assert looks.kinds(0, robot(percentage=0.2)) == []
    (alert,) = looks.alerts(1, robot(percentage=0.19))
    assert (alert.kind, alert.started_at) == (alert_kinds.LOW_BATTERY, NOON + timedelta(seconds=1))
    assert "fell below 20%" in alert.detail
    assert "ends at 25%" in alert.detail
    (same,) = looks.alerts(2, robot(percentage=0.24))
    assert same == alert
    assert looks.kinds(3, robot(percentage=0.25)) == []
    assert looks.kinds(4, robot(percentage=0.24)) == []


@pytest.mark.parametrize(
    "excuse", [{"supply": CHARGING}, {"supply": FULL}, {"goals": [goal("/robot1/dock")]}, {"percentage": None}]
)
def test_a_low_battery_that_somebody_sees_to(excuse: dict[str, Any]) -> None:
    looks = Looks()
    assert looks.kinds(0, robot(percentage=0.1)) == ["low_battery"]
    assert looks.kinds(1, robot(**({"percentage": 0.1} | excuse))) == []
    assert looks.kinds(2, robot(percentage=0.1, goals=[goal("/robot1/undock")])) == ["low_battery"]


CREATE3 = {"supply": UNKNOWN, "left_docked": True}


@pytest.mark.parametrize(
    ("change", "kinds"),
    [
        ({**CREATE3, "current": 1.1}, []),
        ({**CREATE3, "current": None}, []),  # it is where it should be
        ({**CREATE3, "current": 0.0}, []),  # it measures none
        ({**CREATE3, "current": -0.4}, ["discharging_on_dock", "low_battery"]),
        ({"supply": UNKNOWN, "left_docked": False, "current": 1.1}, ["low_battery"]),  # it brakes
        ({"supply": UNKNOWN, "left_docked": None, "current": 1.1}, ["low_battery"]),
        ({"supply": NOT_CHARGING, "left_docked": True, "current": 1.1}, ["discharging_on_dock", "low_battery"]),
        ({"supply": UNKNOWN, "contact": True, "current": 2.0}, []),
        ({"supply": UNKNOWN, "contact": True, "current": -2.0}, ["discharging_on_dock", "low_battery"]),
    ],
)
def test_whether_a_robot_charges_is_told_by_status_current_and_dock(change: dict[str, Any], kinds: list[str]) -> None:
    looks = Looks()
    looks.kinds(0, robot(percentage=0.1, **change))
    alerts = looks.alerts(60, robot(percentage=0.1, **change))
    assert [alert.kind.value for alert in alerts] == kinds
    by_current = change["supply"] == UNKNOWN and change["current"] and change["current"] < 0
    assert all((CHARGES_NEGATIVE in alert.detail) == bool(by_current) for alert in alerts if "docked" in alert.detail)
    sent_away = [alert for alert in alerts if "Send the robot to its dock" in alert.detail]
    assert not (sent_away and robot(**change).on_dock)


def test_an_implausible_battery_is_one_warning_and_no_low_battery() -> None:
    looks = Looks()
    wrong = robot(percentage=None, doubts=(WRONG,), named=(WRONG,))
    (alert,) = looks.alerts(0, wrong)
    assert (alert.kind, alert.started_at, alert.kind.critical) == (alert_kinds.BATTERY_IMPLAUSIBLE, NOON, False)
    assert "/robot1/battery_status" in alert.detail
    assert "percentage is 12, but should be 0 to 1. Name the robot." in alert.detail
    assert looks.alerts(60, wrong) == [alert]
    assert looks.kinds(61, robot()) == []
    assert looks.alerts(62, wrong)[0].started_at == NOON + timedelta(seconds=62)
    assert looks.kinds(63, robot(percentage=None, doubts=(WRONG,))) == []  # it may have just started


def test_one_wrong_value_does_not_end_a_low_battery() -> None:
    looks = Looks()
    low, wrong = robot(percentage=0.1), robot(percentage=None, doubts=(WRONG,), named=(WRONG,))
    (alert,) = looks.alerts(0, low)
    assert alert in looks.alerts(29, wrong)
    assert alert in looks.alerts(40, low)
    assert alert in looks.alerts(69, wrong)
    assert looks.kinds(70, wrong) == ["battery_implausible"]
    assert looks.kinds(71, low) == ["low_battery"]
    assert looks.kinds(72, robot(percentage=None)) == []


def test_no_battery_is_low_where_nobody_wants_to_know() -> None:
    assert Looks(0.0).kinds(0, robot(percentage=0.0)) == []


def test_a_battery_that_fell_silent() -> None:
    looks = Looks()
    silent = robot(stale_since=NOON)
    assert looks.kinds(5, silent) == []
    (alert,) = looks.alerts(5.1, silent)
    assert (alert.kind, alert.started_at) == (alert_kinds.BATTERY_STALE, NOON)
    assert "/robot1/battery_status" in alert.detail
    assert looks.kinds(6, robot()) == []


def test_critical_ones_come_first_then_the_oldest() -> None:
    looks = Looks()
    low = robot("/a", percentage=0.1)
    looks.alerts(-5, low)
    stopped = robot("/b", latched=True, stale_since=NOON - timedelta(seconds=20))
    assert looks.kinds(1, low, stopped) == ["stop_latched", "battery_stale", "low_battery"]


def test_what_happened_to_the_history_is_an_alert_of_no_robot() -> None:
    incident = Incident(NOON, "It was deleted.")
    (alert,) = AlertRules(0.2).evaluate([], [], NOON + timedelta(hours=1), 1000.0, incident=incident)
    document = alert.document(None)
    named = {name: document[name] for name in ("kind", "robot", "severity", "started_at", "detail")}
    expected = {
        "kind": "history_lost",
        "robot": None,
        "severity": "warning",
        "started_at": NOON,
        "detail": incident.detail,
    }
    assert named == expected


def test_ids_are_the_same_everywhere() -> None:
    assert alert_id(alert_kinds.LOW_BATTERY, "/robot1") == "d52cd72bb043e060"  # as other gateways have it
    names = [(kind, name, goal) for kind in alert_kinds.CORE_KINDS for name in ("/", "/r") for goal in (None, "a")]
    ids = {alert_id(*name) for name in names}
    assert len(ids) == len(names)
    assert all(identity.isalnum() and identity.isascii() for identity in ids)


def test_a_stop_that_is_not_stored() -> None:
    (alert,) = Looks().alerts(0, robot(latched=True, persisted=False))
    assert alert.detail.endswith("It is not stored: a restart of the gateway would lose it.")


def test_the_version_of_an_alert_is_that_of_its_acknowledgement() -> None:
    (alert,) = Looks().alerts(0, robot(latched=True))
    seen, later = Acknowledgement("Ada", NOON), replace(alert, started_at=NOON + timedelta(seconds=1), detail="Other.")
    assert alert.etag(None) == later.etag(None) != alert.etag(seen) == later.etag(seen)
    assert alert.etag(seen) != alert.etag(Acknowledgement("Bob", NOON))


def test_an_alert_as_a_document() -> None:
    (alert,) = Looks().alerts(0, robot(latched=True))
    seen = Acknowledgement("Ada", NOON)
    assert alert.document(seen) == {
        "id": alert.id,
        "etag": alert.etag(seen),
        "kind": "stop_latched",
        "robot": "/robot1",
        "severity": "critical",
        "started_at": NOON,
        "title": "Stopped",
        "detail": alert.detail,
        "goal_id": None,
        "acknowledged": seen,
    }
    assert alert.document(None)["acknowledged"] is None


def test_two_servers_of_one_robot_are_one_alert() -> None:
    watch = AlertRules(0.2)

    def look(seconds: float, **duplicates: list[str]) -> list[Alert]:
        by_robot = {f"/{name}": actions for name, actions in duplicates.items()}
        return watch.evaluate([], [], NOON + timedelta(seconds=seconds), seconds, duplicates=by_robot)

    look(0, robot1=["/robot1/undock"])
    (alert,) = look(5, robot1=["/robot1/undock", "/robot1/dock"])
    assert (alert.kind, alert.robot, alert.started_at) == (alert_kinds.DUPLICATE_ACTION_SERVER, "/robot1", NOON)
    assert alert.kind.critical
    assert "serves /robot1/dock and /robot1/undock" in alert.detail
    assert look(6) == []
    (again,) = look(7, robot1=["/robot1/dock"])
    assert again.started_at == NOON + timedelta(seconds=7)


def test_a_finding_is_an_alert_since_it_was_first_seen() -> None:
    rules, kind = AlertRules(0.2), alert_kinds.OF_FINDINGS[FindingKind.WRONG_TOPIC_TYPE]

    def look(seconds: float, *findings: Finding) -> list[Alert]:
        return rules.evaluate([], [], NOON + timedelta(seconds=seconds), seconds, findings=findings)

    wrong = Finding(FindingKind.WRONG_TOPIC_TYPE, "/", "Wrong", "One.")
    (alert,) = look(0, wrong)
    assert (alert.kind, alert.robot, alert.started_at, alert.critical) == (kind, "/", NOON, False)
    (worse,) = look(5, Finding(FindingKind.WRONG_TOPIC_TYPE, "/", "Wrong", "Two.", critical=True))
    assert (worse.id, worse.started_at, worse.detail) == (alert.id, NOON, "Two.")
    assert worse.document(None)["severity"] == "critical"
    assert look(6) == []
    (again,) = look(7, wrong)
    assert again.started_at == NOON + timedelta(seconds=7)
