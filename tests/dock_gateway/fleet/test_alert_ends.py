"""Every kind of alert ends when what it says is over, and the documentation says when that is."""

import re
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import GoalStatus
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import CORE_KINDS, AlertKind
from dock_gateway.fleet.alert_rules import SPLIT_FOR, STALE_FOR, WITHOUT_POWER, AlertRules
from dock_gateway.fleet.findings import Finding, FindingKind
from dock_gateway.goals.hints import Join
from dock_gateway.storage import Incident
from dock_hub.directory import SILENT_AFTER, SiteState
from dock_hub.overview import Overview
from tests.support.history import HistoryInMemory
from tests.support.robot_states import CHARGING, NOON, WRONG, goal, robot
from tests.support.waiting import until

DOCUMENT = Path(__file__).parents[3] / "docs/robots.md"
K = alert_kinds


@dataclass(frozen=True)
class Life:
    """What an alert is about and what ends it, as arguments of `AlertRules.evaluate`.

    Attributes:
        holds: What holds while it is active.
        over: What holds afterwards; as before, where time ends it.
        begins: Seconds for which it has to hold.
        lasts: Seconds after which it ends.
    """

    holds: dict[str, Any]
    over: dict[str, Any] = field(default_factory=lambda: {"states": [robot()]})
    begins: float = 0.0
    lasts: float = 0.5


INCIDENT = Incident(NOON, "It was deleted.")
FAILED = Alert(K.EXTENSION_FAILED, None, NOON, "No maps", "They could not be opened.")
LOST = [goal("/robot1/dock", GoalStatus.LOST)]
JOIN = Join("/robot1", "/", [], "Set it.")
LIVES = {
    K.STOP_LATCHED: [Life({"states": [robot(latched=True)]})],
    K.GOAL_LOST: [
        Life({"states": [robot(lost=LOST)]}),  # test_overview.py has when a lost goal of a robot is one no longer
        Life({"states": [robot(lost=LOST)]}, {"states": [robot(lost=LOST)]}, lasts=3600.0),
        Life({"strays": LOST}, {"strays": LOST}, lasts=3600.0),
    ],
    K.DISCHARGING_ON_DOCK: [
        Life({"states": [robot(left_docked=True)]}, {"states": [each]}, begins=WITHOUT_POWER)
        for each in (
            robot(left_docked=True, supply=CHARGING),
            robot(left_docked=True, percentage=1.0),
            robot(left_docked=True, goals=[goal("/robot1/undock")]),
            robot(left_docked=False),
        )
    ],
    K.LOW_BATTERY: [
        Life({"states": [robot(percentage=0.1)]}, {"states": [each]})
        for each in (
            robot(),
            robot(percentage=0.1, supply=CHARGING),
            robot(percentage=0.1, goals=[goal("/robot1/dock")]),
        )
    ],
    K.BATTERY_IMPLAUSIBLE: [Life({"states": [robot(named=(WRONG,))]})],
    K.BATTERY_STALE: [Life({"states": [robot(stale_since=NOON)]}, begins=STALE_FOR.total_seconds() + 0.1)],
    K.HISTORY_LOST: [Life({"incident": INCIDENT})],
    K.DUPLICATE_ACTION_SERVER: [Life({"duplicates": {"/robot1": ["/robot1/dock"]}})],
    K.EXTENSION_FAILED: [Life({"further": [FAILED]})],
    K.SPLIT_ROBOT: [Life({"split": [JOIN]}, begins=SPLIT_FOR)],
    **{
        K.OF_FINDINGS[each]: [Life({"findings": [Finding(each, "/robot1", "Wrong", "It is.")]})] for each in FindingKind
    },
}
OF_A_HUB = {
    K.SITE_UNREACHABLE: (SiteState.UNREACHABLE, SiteState.CONNECTED),
    K.SITE_REFUSED: (SiteState.REFUSED, SiteState.CONNECTED),
}
OF_A_ROBOT = [
    (kind, life) for kind, lives in LIVES.items() for life in lives if kind.value.startswith(("battery", "low", "dis"))
]


def kinds(rules: AlertRules, seconds: float, what: dict[str, Any]) -> list[AlertKind]:
    look = {"states": [], "strays": []} | what
    alerts = rules.evaluate(
        look.pop("states"), look.pop("strays"), NOON + timedelta(seconds=seconds), 1000 + seconds, **look
    )
    return [alert.kind for alert in alerts]


@pytest.mark.parametrize("kind", CORE_KINDS, ids=str)
def test_what_ends_each_kind_is_tested_and_documented(kind: AlertKind) -> None:
    assert kind in LIVES.keys() | OF_A_HUB.keys(), f"what ends {kind}?"
    (row,) = re.findall(rf"^\| `{kind.value}` \|(.*)\|$", DOCUMENT.read_text(), re.MULTILINE)
    severity, active, ends = (cell.strip() for cell in row.split("|"))
    assert severity in {"critical", "warning"}
    assert active
    assert ends


@pytest.mark.parametrize(("kind", "life"), [(kind, life) for kind, lives in LIVES.items() for life in lives])
def test_it_ends_when_what_it_says_is_over(kind: AlertKind, life: Life) -> None:
    rules = AlertRules(0.2)
    kinds(rules, 0.0, life.holds)
    assert kind in kinds(rules, life.begins, life.holds)
    assert kind not in kinds(rules, life.begins + life.lasts, life.over)


@pytest.mark.parametrize(("kind", "life"), OF_A_ROBOT)
def test_none_outlives_its_robot(kind: AlertKind, life: Life) -> None:
    rules = AlertRules(0.2)
    kinds(rules, 0.0, life.holds)
    assert kind in kinds(rules, life.begins, life.holds)
    assert kinds(rules, life.begins + 0.5, {}) == []


@pytest.mark.parametrize(("kind", "states"), OF_A_HUB.items())
async def test_one_about_a_site_ends_when_the_site_is_back_or_gone(
    kind: AlertKind, states: tuple[SiteState, SiteState]
) -> None:
    silent, back = states
    here = {"berlin": silent}
    sites: Any = SimpleNamespace(
        names=lambda: [*here],
        views=list,
        find=lambda _: SimpleNamespace(since=0.0, detail=""),
        state=lambda name: here[name],
        silent_for=lambda _: SILENT_AFTER,
    )
    goals: Any = None
    shown = Overview(Fanout(queue_limit=10), sites, goals, HistoryInMemory())

    def is_active() -> bool:
        return [each["kind"] for each in shown.documents()] == [kind.value]

    def is_over() -> bool:
        return shown.documents() == []

    try:
        await until(is_active)
        here["berlin"] = back
        await until(is_over)
        here["berlin"] = silent
        await until(is_active)
        here.clear()
        await until(is_over)
    finally:
        await shown.close()
