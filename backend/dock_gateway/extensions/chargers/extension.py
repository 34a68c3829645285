"""Docks that several robots share: at most one robot has each, and the others wait."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.extension import Extension
from dock_gateway.extensions.chargers.alerts import KINDS, dock_alerts
from dock_gateway.extensions.chargers.board import DockBoard
from dock_gateway.extensions.chargers.distances import Distances
from dock_gateway.extensions.chargers.dock import DockEntry, DockRecord, WaitEntry
from dock_gateway.extensions.chargers.dock_file import UNREAD, DockFile
from dock_gateway.extensions.chargers.error_codes import CODES
from dock_gateway.extensions.chargers.metrics import dock_metrics
from dock_gateway.extensions.chargers.reload_port import ReloadPort
from dock_gateway.extensions.chargers.routes import router
from dock_gateway.extensions.chargers.schema import EVENTS
from dock_gateway.extensions.chargers.settings import ChargerSettings
from dock_gateway.extensions.chargers.shared_docks import MAX_DOCKS, SharedDocks
from dock_gateway.extensions.chargers.tools import TOOLS
from dock_gateway.extensions.chargers.watch import DockWatch
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.robots.labels import Labels
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook, SharedEntries


@asynccontextmanager
async def open_chargers(parts: Parts) -> AsyncIterator[DockBoard]:
    """Let each docking goal ask for its dock, and follow who stands there."""
    async with AsyncExitStack() as stack:
        actions, history, fleet, robots = parts[ActionRegistry], parts[History], parts[Fleet], parts[RobotRegistry]
        settings = parts[Settings].of(ChargerSettings)
        docks = SharedDocks(
            SharedBook(history.documents("shared_dock", DockEntry), "shared_dock", MAX_DOCKS),
            SharedEntries(history.documents("dock_record", DockRecord)),
            SharedEntries(history.documents("dock_wait", WaitEntry)),
            robots=robots,
            actions=actions,
            docks=parts[Docks],
            labels=parts[Labels],
            distances=Distances(parts[Settings], parts[Relays], parts[GraphCache]),
            can_drive=lambda goal: can_drive(goal, robots, fleet),
            by_charge=settings.chargers_queue == "lowest_charge",
        )
        await docks.sync()
        watch = closed_by(
            stack, DockWatch(docks, fleet, parts[Goals], parts[Share], failures=settings.chargers_failures)
        )
        board = DockBoard(docks, watch, fleet, parts[Fanout])
        stack.enter_context(watch.on_look.adding(board.publish))
        stack.enter_context(actions.gates.adding(docks.admit))
        for listeners in (actions.on_end, actions.on_lost):
            stack.enter_context(listeners.adding(watch.wake))
        stack.enter_context(parts[AlertBoard].sources.adding(lambda: dock_alerts(docks, watch.trouble)))
        if settings.chargers_file is not None:
            file = closed_by(stack, DockFile(settings.chargers_file, docks, parts[Docks], ReloadPort(parts[Bridge])))
            stack.enter_context(parts[AlertBoard].sources.adding(file.alerts))
            file.start()
        watch.start()
        yield board


def can_drive(goal: Goal, robots: RobotRegistry, fleet: Fleet) -> bool:
    """Return whether the robot of a goal that waits for its dock may drive to a waiting place.

    It waits where it is if no mission has sent the goal, if it stands on a dock, and while another goal runs on it.
    """
    robot = robots.owner(goal.action_name)
    state = None if robot is None else fleet.state(robot.namespace)
    if state is None or not robots.is_at_work(state.name) or state.on_dock:
        return False
    return all(other.goal_id == goal.goal_id for other in state.goals)


extension = Extension(
    "chargers",
    open_chargers,
    settings=ChargerSettings,
    routes=lambda _: (router,),
    events=EVENTS,
    alerts=(*KINDS, UNREAD),
    errors=CODES,
    metrics=dock_metrics,
    tools=TOOLS,
)
