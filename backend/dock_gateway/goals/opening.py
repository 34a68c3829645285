"""Opens the actions and their goals."""

from contextlib import AsyncExitStack

from dock_gateway.core.event import system_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import GoalError
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import PendingFacts, closed_by
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.goals.unfinished import store_unfinished
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.labels import Labels
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.simulator import Simulators
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.robot_ports import DiagnosticsPort
from dock_gateway.settings import Settings
from dock_gateway.storage import History

# Seconds that a rejected or aborted goal waits for the server's reason.
REASON_WAIT = 0.3


async def open_goals(parts: Parts, stack: AsyncExitStack) -> None:
    """Open the actions of the robots, the docks they know, and what goals wait for before they are sent."""
    settings, bridge, history, robots = parts[Settings], parts[Bridge], parts[History], parts[RobotRegistry]
    robot_actions = parts.add(RobotActions, RobotActions(settings, robots, parts[Labels], history))
    reasons: PendingFacts[GoalError] = PendingFacts(REASON_WAIT)
    actions = ActionRegistry(
        settings,
        bridge,
        parts[Fanout],
        history,
        reasons,
        interlock=parts[Interlock],
        robots=robots,
        robot_actions=robot_actions,
        share=parts[Share],
        limits=parts[GoalLimits],
    )
    parts.add(ActionRegistry, closed_by(stack, actions))
    history.on_loss.append(lambda: store_unfinished(actions, history))
    parts.add(Goals, Goals(actions, robot_actions, history))
    parts.add(GoalDocuments, GoalDocuments(history))
    parts.add(KnownRobots, KnownRobots(settings, robots, parts[Labels], robot_actions, history))
    parts.add(Docks, closed_by(stack, Docks(bridge)))
    parts.add(DockingHints, DockingHints(settings, actions, robots))
    _follow_docking(parts)
    _ask_for_approval(parts, stack)
    await _listen_to_servers(parts, reasons)


def _follow_docking(parts: Parts) -> None:
    """Note and publish which actions dock and undock a robot, whenever that changes."""
    actions, robot_actions, last_goals = parts[ActionRegistry], parts[RobotActions], parts[LastGoals]

    def changed(robot: str) -> None:
        last_goals.watch(*robot_actions.docking_pair(robot))
        parts[Fanout].publish(system_event("docking", actions.servers_of(robot)._asdict(), utc_now(), robot=robot))

    robot_actions.on_change.append(changed)
    actions.on_end.append(last_goals.take)


def _ask_for_approval(parts: Parts, stack: AsyncExitStack) -> None:
    """Let the goals of agents wait for approval; a stop drops those that wait."""
    actions, interlock = parts[ActionRegistry], parts[Interlock]
    approvals = Approvals(parts[Settings], parts[Fanout], actions.verb_of, parts[Simulators].__contains__)
    parts.add(Approvals, closed_by(stack, approvals))
    actions.before_send.append(approvals.require)
    interlock.on_latch.append(approvals.drop)


async def _listen_to_servers(parts: Parts, reasons: PendingFacts[GoalError]) -> None:
    """Listen to what servers and simulators report on `/diagnostics`."""
    settings, robots = parts[Settings], parts[RobotRegistry]
    actions, simulators = parts[ActionRegistry], parts[Simulators]
    await parts[Bridge].call(
        lambda: DiagnosticsPort(
            robots.topics,
            settings.diagnostics_topic,
            stop_topic=settings.resolve(settings.stop_state_topic),
            on_reason=reasons.put,
            on_progress=actions.on_progress,
            on_simulator=simulators.on_report,
        )
    )
