"""Automatic docking with its parts: what is sent, what is recorded, and what happens without the history."""

import asyncio
from collections.abc import AsyncIterator, Callable
from datetime import timedelta
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.battery import BatteryReading
from dock_gateway.core.dock_adapters.catalog import DockingPair
from dock_gateway.core.errors import Conflict, DockOccupied, GatewayError, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.extensions.automation import docking, facts
from dock_gateway.extensions.automation.activity import Activity
from dock_gateway.extensions.automation.decision import DecisionEntry, DecisionOutcome, RuleMode
from dock_gateway.extensions.automation.decisions import DecisionLog
from dock_gateway.extensions.automation.docking import AutomaticDocking
from dock_gateway.extensions.automation.facts import FactReader
from dock_gateway.extensions.automation.past import MAX_ATTEMPTS
from dock_gateway.extensions.automation.rule import BatteryCondition, RuleEntry
from dock_gateway.extensions.automation.rules import DockingRules
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.liveness import ServerState
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.labels import NO_LABEL
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook
from tests.extensions.automation.examples import LOW_BATTERY, changed, decision_entry
from tests.support.entries import SharedStore
from tests.support.history import HistoryInMemory
from tests.support.waiting import until

ROBOT = "/robot1"
# Idle for no time at all: what counts here is what follows.
AT_ONCE = changed(LOW_BATTERY, battery=BatteryCondition.model_construct(below=0.2, idle_s=0.0))


class Robot:
    """A robot with an empty battery, and what is sent to its dock server."""

    def __init__(self) -> None:
        self.stop: dict[str, Any] = {"latched": False, "stopped_at": utc_now(), "by": "Ada"}
        self.names = [ROBOT]  # with others that share its dock server
        self.sent: list[str | None] = []
        self.refusal: GatewayError | None = None
        self.on_submit: Callable[[], None] = lambda: None
        self.on_dock = False
        self.power_supply = 2
        self.simulator: dict[str, Any] | None = None

    def states(self) -> list[Any]:
        battery = SimpleNamespace(reading=BatteryReading(self.power_supply, 0.1), age=0.1, stale_since=None)
        return [
            SimpleNamespace(
                name=name,
                default=False,
                label=NO_LABEL,
                battery=battery,
                on_dock=self.on_dock,
                simulator=self.simulator,
                dock=ServerState(f"{ROBOT}/dock", "pkg/action/Dock", available=True, answering=True),
                goals=[],
                lost=[],
                stop=self.stop,
                last_goal=None,
            )
            for name in self.names
        ]

    async def submit(self, _: object, key: str, *, sender: None) -> Goal:
        assert sender is None
        self.on_submit()
        if self.refusal is not None:
            raise self.refusal
        self.sent.append(key)
        return Goal("a", f"{ROBOT}/dock", "pkg/action/Dock", utc_now(), origin="automation")

    def docking_pair(self, robot: str) -> DockingPair:
        return DockingPair(f"{robot}/dock", f"{robot}/undock")

    def get(self, name: str) -> Any:
        assert name == f"{ROBOT}/dock"
        return SimpleNamespace(read_docking_request=dict, submitter=self)


class Site:
    """Gateways that share a history and see one robot."""

    def __init__(self) -> None:
        self.robot = Robot()
        self.rules, self.stored = SharedStore[RuleEntry](), SharedStore[DecisionEntry]()
        self.gateways: list[AutomaticDocking] = []
        self.activities: list[Activity] = []  # of each of them
        self.history = HistoryInMemory()
        self.held: SharedStore[LastStop] = SharedStore()
        self.fanout = Fanout(queue_limit=10)

    def activity(self) -> Activity:
        activity = Activity(cast("RobotRegistry", SimpleNamespace(owner=lambda _: None)))
        activity.on_watch(
            "cmd_vel", lambda: [activity.subscribed(robot, lambda: True) for robot in activity.watched("cmd_vel")]
        )
        return activity

    def gateway(self, sync_every: int = 2) -> DockingRules:
        fleet, activity = cast("Fleet", self.robot), self.activity()
        robots = SimpleNamespace(owner=lambda _: SimpleNamespace(namespace=ROBOT), on_low_battery=lambda *_: None)
        decisions = DecisionLog(self.fanout, self.stored)
        rules = DockingRules(fleet, SharedBook(self.rules, "rule", 50), decisions, LastStops(self.held))
        gateway = AutomaticDocking(
            rules,
            FactReader(fleet, activity, held=rules.holds),
            activity,
            actions=cast("ActionRegistry", self.robot),
            robot_actions=cast("RobotActions", self.robot),
            history=cast("History", self.history),
            robots=cast("RobotRegistry", robots),
            interval=0.01,
            sync_every=sync_every,
        )
        self.activities.append(activity)
        self.gateways.append(gateway)
        gateway.start()
        return rules

    async def decided(self, count: int = 1) -> list[DecisionEntry]:
        def all_final() -> list[DecisionEntry]:
            found = list(self.stored.known.values())
            return [] if any(each.outcome is DecisionOutcome.SENDING for each in found) else found

        await until(lambda: len(all_final()) >= count)
        return sorted(all_final(), key=lambda decision: decision.decided_at)


@pytest.fixture
async def site() -> AsyncIterator[Site]:
    site = Site()
    yield site
    for gateway in site.gateways:
        await gateway.close()


async def waits(rules: DockingRules) -> list[str]:
    (rule,) = await rules.documents()
    return [robot["waits_for"] for robot in rule["applies_to"]]


async def test_no_rule_docks_a_robot_that_was_stopped_until_somebody_says_so(site: Site) -> None:
    rules = site.gateway()
    rules.on_stop(ROBOT)
    assert not rules.holds(ROBOT), "no rule is on"
    site.robot.stop["latched"] = True
    await rules.replace("low", AT_ONCE)
    rules.on_stop(ROBOT)
    await site.decided()
    site.robot.stop["latched"] = False
    rules.on_release(ROBOT)
    other = site.gateway()  # or this one, after a restart
    await until(lambda: other.holds(ROBOT))
    await asyncio.sleep(0.1)
    assert (await waits(rules), await waits(other)) == (["stopped"], ["stopped"])
    assert site.robot.sent == []
    await rules.last_stops.allow(ROBOT)
    await site.decided(2)
    assert len(site.robot.sent) == 1


async def test_a_stop_is_stored_at_once(site: Site) -> None:
    rules = site.gateway(sync_every=1000)
    await rules.replace("low", changed(LOW_BATTERY, mode=RuleMode.DRY_RUN))
    (gateway,) = site.gateways
    rules.on_stop(ROBOT)
    gateway.save_holds(ROBOT)
    await until(lambda: ROBOT in site.held.known)
    await gateway.close()  # it is killed, and starts again
    other = site.gateway()
    await until(lambda: other.holds(ROBOT))


@pytest.mark.parametrize("origin", ["gateway", "external", "automation"])
@pytest.mark.parametrize("status", [GoalStatus.SUCCEEDED, GoalStatus.ABORTED, GoalStatus.CANCELED])
async def test_who_has_driven_the_robot_since_has_let_the_rules_go_on(
    site: Site, origin: Any, status: GoalStatus
) -> None:
    rules = site.gateway()
    await rules.replace("low", changed(LOW_BATTERY, mode=RuleMode.DRY_RUN))
    before = Goal("a", f"{ROBOT}/dock", "pkg/action/Dock", utc_now(), origin)
    rules.on_stop(ROBOT)
    after = Goal("b", f"{ROBOT}/dock", "pkg/action/Dock", utc_now(), origin)
    for goal in (before, after):
        goal.advance(status, utc_now())
    (gateway,) = site.gateways
    gateway.on_end(before)
    await asyncio.sleep(0.05)
    assert rules.holds(ROBOT)
    gateway.on_end(after)
    await asyncio.sleep(0.05)
    assert rules.holds(ROBOT) is (origin == "automation" or status is not GoalStatus.SUCCEEDED)


async def test_no_goal_is_sent_to_a_server_that_robots_share(site: Site) -> None:
    gateway = site.gateway()
    site.robot.names.append("/robot2")
    await gateway.replace("low", AT_ONCE)
    await asyncio.sleep(0.2)
    (rule,) = await gateway.documents()
    assert [robot["waits_for"] for robot in rule["applies_to"]] == ["shared_action", "shared_action"]
    assert await site.stored.read() == {}
    site.robot.names.pop()
    await site.decided()
    assert len(site.robot.sent) == 1


async def test_a_robot_that_joins_before_the_goal_is_sent_to_its_server_prevents_that(site: Site) -> None:
    gateway = site.gateway()
    write = site.stored.write

    async def claim(*args: Any) -> None:
        site.robot.names = [ROBOT, "/robot2"]
        await write(*args)

    site.stored.write = claim  # type: ignore[method-assign]
    await gateway.replace("low", AT_ONCE)
    (decision,) = await site.decided()
    assert (decision.outcome, decision.code) == (DecisionOutcome.SKIPPED, "shared_action")
    assert site.robot.sent == []


@pytest.mark.parametrize(
    ("power_supply", "contact", "docks"), [(2, None, True), (2, False, True), (2, True, False), (3, None, False)]
)
async def test_a_robot_that_has_slid_off_its_contacts_is_docked_again(
    site: Site, monkeypatch: pytest.MonkeyPatch, power_supply: int, contact: bool | None, docks: bool
) -> None:
    """By its goals it is docked still; a battery that discharges for a while says otherwise, unless it touches."""
    monkeypatch.setattr(facts, "OFF_CHARGER", 0.3)
    site.robot.on_dock, site.robot.power_supply = True, power_supply
    site.robot.simulator = None if contact is None else {"contact": contact, "docked": False}
    gateway = site.gateway()
    await gateway.replace("low", AT_ONCE)
    await asyncio.sleep(0.1)
    assert site.robot.sent == [], "contacts bounce"
    if docks:
        (decision,) = await site.decided()
        assert decision.outcome is DecisionOutcome.SENT
        assert len(site.robot.sent) == 1
        return
    await asyncio.sleep(0.6)
    (rule,) = await gateway.documents()
    assert [robot["waits_for"] for robot in rule["applies_to"]] == ["docked"]
    assert site.robot.sent == []


async def test_two_gateways_send_one_goal_and_both_publish_it_once(
    site: Site, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    first, second = site.gateway(), site.gateway()
    reader = site.fanout.subscribe(EventFilter(frozenset({"automation"})))
    await asyncio.sleep(0.1)
    await first.replace("low", AT_ONCE)
    (decision,) = await site.decided()
    assert (decision.outcome, decision.goal_id) == (DecisionOutcome.SENT, "a")
    await until(lambda: list(second.decisions.all().values()) == [decision])
    assert len(site.robot.sent) == 1
    events, _ = await reader.take(1.0)
    assert len([event for event in events if b'"automation"' in event.data]) == 2  # one by each, here at one fanout
    assert sum("automatic docking of /robot1" in line for line in caplog.messages) == 1


async def test_a_refused_goal_is_recorded_with_its_code(site: Site) -> None:
    site.robot.refusal = Conflict("busy", code="dock_busy", goal_id="b")
    await site.gateway().replace("low", AT_ONCE)
    (decision,) = await site.decided()
    assert (decision.outcome, decision.code, decision.goal_id) == (DecisionOutcome.REFUSED, "dock_busy", "b")


@pytest.mark.parametrize("code", ["stop_latched", "stopped"])
async def test_a_stop_between_the_decision_and_the_goal_wins(site: Site, code: str) -> None:
    gateway = site.gateway()
    site.robot.refusal = Conflict("a stop", code=code)
    site.robot.on_submit = lambda: site.activities[0].intervened(ROBOT)
    await gateway.replace("low", AT_ONCE)
    (decision,) = await site.decided()
    assert (decision.outcome, decision.code) == (DecisionOutcome.HELD, code)


async def test_what_changes_while_the_decision_is_stored_counts(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    claim = DecisionLog.claim

    async def stopped_meanwhile(log: DecisionLog, identity: str, decision: DecisionEntry) -> None:
        await claim(log, identity, decision)
        site.robot.stop["latched"] = True

    monkeypatch.setattr(DecisionLog, "claim", stopped_meanwhile)
    await site.gateway().replace("low", AT_ONCE)
    (decision,) = await site.decided()
    assert (decision.outcome, decision.code) == (DecisionOutcome.HELD, "stop_latched")
    assert site.robot.sent == []


async def test_without_the_history_nothing_docks(site: Site, caplog: pytest.LogCaptureFixture) -> None:
    await site.rules.write("low", AT_ONCE)
    gateway = site.gateway()
    await until(lambda: bool(site.stored.known))
    site.stored.known.clear()
    site.robot.sent.clear()
    await gateway.decisions.sync()
    site.rules.away = site.stored.away = True
    await until(lambda: any("no automatic docking" in line for line in caplog.messages))
    with pytest.raises(Unavailable):
        await gateway.documents()
    with pytest.raises(Unavailable):
        await gateway.decisions.page(limit=1)
    with pytest.raises(Unavailable):
        await gateway.replace("low", changed(AT_ONCE, mode=RuleMode.OFF))
    assert sum("no automatic docking" in line for line in caplog.messages) == 1


async def test_a_decision_that_cannot_be_claimed_is_not_carried_out(site: Site) -> None:
    site.stored.away = True
    await site.rules.write("low", AT_ONCE)
    site.gateway()
    await asyncio.sleep(0.2)
    assert site.robot.sent == []
    site.stored.away = False
    await site.decided()
    assert len(site.robot.sent) == 1


@pytest.mark.parametrize("sent", [True, False])
async def test_what_an_ended_gateway_left_is_found_out(site: Site, sent: bool) -> None:
    earlier = utc_now() - timedelta(minutes=2)
    await site.stored.write("x", decision_entry(decided_at=earlier, idle_since_at=earlier))
    await site.rules.write("low", AT_ONCE)
    if sent:
        goal = Goal("b", f"{ROBOT}/dock", "pkg/action/Dock", earlier)
        goal.advance(GoalStatus.EXECUTING, earlier)
        await site.history.add(goal, "automatic-docking-x")
    site.gateway()
    (decision,) = await site.decided()
    assert (decision.outcome, decision.goal_id) == (
        (DecisionOutcome.SENT, "b") if sent else (DecisionOutcome.REFUSED, None)
    )
    assert decision.code == (None if sent else "interrupted")
    assert site.robot.sent == []


async def test_a_changed_rule_begins_anew_and_gives_up_no_more(site: Site) -> None:
    gateway = site.gateway()
    now = utc_now() - timedelta(hours=1)
    await site.stored.write("x", decision_entry(decided_at=now, outcome=DecisionOutcome.GAVE_UP))
    await gateway.replace("low", AT_ONCE)
    assert gateway.decisions.given_up() == {}
    assert [decision.outcome for decision in await site.decided(2)] == [DecisionOutcome.GAVE_UP, DecisionOutcome.SENT]


async def test_a_gateway_that_does_not_know_of_a_change_yet_decides_nothing_by_the_old_rule(site: Site) -> None:
    first = site.gateway()
    await first.replace("low", changed(AT_ONCE, mode=RuleMode.DRY_RUN))
    await site.decided()
    second = site.gateway(sync_every=1_000_000)  # it reads once, at its start
    await until(lambda: [each.outcome for each in second.decisions.all().values()] == [DecisionOutcome.DRY_RUN])
    await first.replace("low", AT_ONCE)
    assert [decision.outcome for decision in await site.decided(2)] == [DecisionOutcome.DRY_RUN, DecisionOutcome.SENT]
    second.decisions.close_rule("low")  # as if it had read the decisions, but not the rule
    await asyncio.sleep(0.2)
    assert [decision.outcome for decision in await site.decided(2)] == [DecisionOutcome.DRY_RUN, DecisionOutcome.SENT]


async def test_the_oldest_decisions_are_deleted(site: Site) -> None:
    old = utc_now() - timedelta(hours=1)
    log = DecisionLog(site.fanout, site.stored, most=2)
    for minute in range(4):
        at = old + timedelta(minutes=minute)
        log.finish(str(minute), decision_entry(decided_at=at, outcome=DecisionOutcome.SENT, open=False))
    await log.save()
    assert sorted(await site.stored.read()) == ["2", "3"]
    found, _ = await log.page(limit=1)
    assert [decision["id"] for decision in found] == ["3"]


async def test_an_old_decision_that_counts_is_kept(site: Site) -> None:
    """Otherwise the rule would send a robot again that it has given up, and the alert about that would end."""
    old = utc_now() - timedelta(days=1)
    log = DecisionLog(site.fanout, site.stored, most=2)
    log.finish("gave up", decision_entry(decided_at=old, outcome=DecisionOutcome.GAVE_UP))
    for day in range(3):
        at = old + timedelta(hours=1 + day)
        log.finish(
            str(day),
            decision_entry(rule_id="night", robot="/robot2", decided_at=at, outcome=DecisionOutcome.SENT, open=False),
        )
    await log.save()
    assert sorted(await site.stored.read()) == ["1", "2", "gave up"]
    assert [*log.given_up()] == [ROBOT]
    log.close_series(["gave up"])
    log.finish(
        "3",
        decision_entry(
            rule_id="night", robot="/robot2", decided_at=utc_now(), outcome=DecisionOutcome.SENT, open=False
        ),
    )
    await log.save()
    assert sorted(await site.stored.read()) == ["2", "3"]


def test_what_counts_as_activity(caplog: pytest.LogCaptureFixture) -> None:
    robots = SimpleNamespace(owner=lambda _: SimpleNamespace(namespace=ROBOT))
    activity = Activity(cast("RobotRegistry", robots))
    assert activity.still_since(ROBOT) is None
    changes: list[set[str]] = []
    activity.on_watch("cmd_vel", lambda: changes.append(activity.watched("cmd_vel")))
    activity.watch({ROBOT})
    assert activity.still_since(ROBOT) is None, "it is not subscribed to yet: that may have failed"
    activity.subscribed(ROBOT, lambda: False)
    assert activity.still_since(ROBOT) is None, "not all of it is heard"
    activity.subscribed(ROBOT, lambda: True)
    activity.watch({ROBOT})
    since = activity.still_since(ROBOT)
    assert since is not None
    still = b'{"linear":{"x":-0.0,"y":0.0,"z":0},"angular":{"x":0.0,"y":0.0,"z":0.0}}'
    activity.on_velocity(ROBOT, still)
    assert activity.still_since(ROBOT) == since
    moved = since
    for value in (b"0.1", b"1e-300", b"-1e300", b"null"):  # nobody knows what a base makes of NaN
        before = moved
        activity.on_velocity(ROBOT, still.replace(b'"z":0}', b'"z":%b}' % value))
        moved = activity.still_since(ROBOT) or 0.0
        assert moved > before
    assert [record.message for record in caplog.records] == [
        f"velocities of {ROBOT} are NaN or infinite, which counts as motion: no rule docks it"
    ]
    goal = Goal("a", f"{ROBOT}/dock", "pkg/action/Dock", utc_now())
    goal.advance(GoalStatus.SUCCEEDED, utc_now())
    activity.on_end(goal)
    assert activity.person_at(ROBOT) is None
    canceled = Goal("a", f"{ROBOT}/dock", "pkg/action/Dock", utc_now())
    canceled.advance(GoalStatus.CANCELED, utc_now())
    activity.on_end(canceled)
    assert (activity.person_at(ROBOT) or 0.0) > moved
    assert (activity.still_since(ROBOT) or 0.0) > moved
    activity.keep(set())
    activity.watch(set())
    assert (activity.person_at(ROBOT), activity.still_since(ROBOT)) == (None, None)
    assert changes == [{ROBOT}, set()]
    activity.unsubscribed(ROBOT)
    activity.watch({ROBOT})
    assert activity.still_since(ROBOT) is None, "it is not subscribed to again yet"


async def test_a_robot_whose_dock_is_occupied_waits_and_that_is_no_attempt(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(docking, "ASK_AGAIN", 0.1)
    asked: list[None] = []
    site.robot.refusal = DockOccupied("/robot2 stands on the dock")
    site.robot.on_submit = lambda: asked.append(None)
    rules = site.gateway()
    await rules.replace("low", AT_ONCE)
    await until(lambda: len(asked) > MAX_ATTEMPTS)
    assert await waits(rules) == ["dock_occupied"]
    site.robot.refusal = None
    (decision,) = await site.decided()
    (identity,) = site.stored.known
    assert (decision.outcome, site.robot.sent) == (DecisionOutcome.SENT, [f"automatic-docking-{identity}"])
