"""Automatic docking: rules that send a robot to its dock when its battery is low, or when it has nothing to do."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.tasks import closed_by
from dock_gateway.extension import Extension
from dock_gateway.extensions.automation.activity import Activity
from dock_gateway.extensions.automation.decision import DecisionEntry
from dock_gateway.extensions.automation.decisions import DecisionLog
from dock_gateway.extensions.automation.docking import AutomaticDocking
from dock_gateway.extensions.automation.error_codes import CODES
from dock_gateway.extensions.automation.facts import FactReader
from dock_gateway.extensions.automation.routes import router
from dock_gateway.extensions.automation.rule import RuleEntry
from dock_gateway.extensions.automation.rules import MAX_RULES, DockingRules
from dock_gateway.extensions.automation.schema import EVENTS
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.graph_watch import GraphWatch
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.on_demand import OnDemand
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook

GAVE_UP = AlertKind("automatic_docking_failed")


@asynccontextmanager
async def open_automation(parts: Parts) -> AsyncIterator[DockingRules]:
    """Apply the rules."""
    async with AsyncExitStack() as stack:
        robots, actions, history = parts[RobotRegistry], parts[ActionRegistry], parts[History]
        fleet, graph_watch = parts[Fleet], parts[GraphWatch]
        activity = Activity(robots)
        closed_by(
            stack, OnDemand(robots.topics.bridge, activity, "motion", lambda robot: _follow(parts, activity, robot))
        )
        decisions = DecisionLog(parts[Fanout], history.documents("decision", DecisionEntry))
        stack.enter_context(parts[AlertBoard].sources.adding(lambda: gave_up(decisions, robots.namespaces())))
        last_stops = LastStops(history.documents("hold", LastStop))
        book = SharedBook(history.documents("rule", RuleEntry), "rule", MAX_RULES)
        rules = DockingRules(fleet, book, decisions, last_stops)
        docking = AutomaticDocking(
            rules,
            FactReader(fleet, activity, lambda: graph_watch.shared, robots.is_at_work, rules.holds),
            activity,
            actions=actions,
            robot_actions=parts[RobotActions],
            history=history,
            robots=robots,
        )
        for on_stop in (activity.active, rules.on_stop, docking.save_holds):
            stack.enter_context(parts[Stopper].on_stop.adding(on_stop))
        for on_release in (activity.active, rules.on_release, docking.save_holds):
            stack.enter_context(parts[Interlock].on_release.adding(on_release))
        for on_end in (activity.on_end, docking.on_end):
            stack.enter_context(actions.on_end.adding(on_end))
        closed_by(stack, docking).start()
        yield rules


def _follow(parts: Parts, activity: Activity, robot: str) -> ExitStack:
    """Follow whether a robot moves."""
    settings = parts[Settings]
    topic = settings.resolve(settings.cmd_vel_topic, robot)
    listener = parts[RobotRegistry].velocities.listen(topic, lambda message, _: activity.on_velocity(robot, message))
    activity.subscribed(robot, lambda: listener.complete)
    port = ExitStack()
    port.callback(listener.close)
    port.callback(activity.unsubscribed, robot)
    return port


def gave_up(decisions: DecisionLog, robots: list[str]) -> list[Alert]:
    """Return an alert for each of these robots that no rule could dock."""
    given_up = decisions.given_up()
    return [_alert(given_up[robot]) for robot in robots if robot in given_up]


def _alert(decision: DecisionEntry) -> Alert:
    return Alert(
        GAVE_UP,
        decision.robot,
        decision.decided_at,
        "Automatic docking gave up",
        f"The rule {decision.rule_name!r} could not dock {decision.robot}, whose battery is low. Check what stopped "
        "it, then send it to its dock.",
    )


extension = Extension(
    "automation",
    open_automation,
    routes=lambda _: (router,),
    events=EVENTS,
    alerts=(GAVE_UP,),
    errors=CODES,
)
