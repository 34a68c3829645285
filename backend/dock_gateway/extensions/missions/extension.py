"""Missions: steps that a robot takes one after the other, stored, so that they survive restarts."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.share import Share
from dock_gateway.core.tasks import closed_by
from dock_gateway.extension import Extension
from dock_gateway.extensions.missions.actions import covers
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.candidates import Candidates
from dock_gateway.extensions.missions.error_codes import CODES
from dock_gateway.extensions.missions.facts import FactsReader
from dock_gateway.extensions.missions.messages import Messages
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.notices import NOTICE, RETURN_FAILED, UNAPPROVED, alerts_of_holds
from dock_gateway.extensions.missions.places import routes as of_places
from dock_gateway.extensions.missions.places.place import PlaceEntry
from dock_gateway.extensions.missions.places.places import MAX_PLACES, Places
from dock_gateway.extensions.missions.routes import router
from dock_gateway.extensions.missions.runner import MissionRunner
from dock_gateway.extensions.missions.schedules import routes as of_schedules
from dock_gateway.extensions.missions.schedules.schedule import ScheduleEntry
from dock_gateway.extensions.missions.schedules.scheduler import Scheduler
from dock_gateway.extensions.missions.schedules.schedules import BY_THEMSELVES, FAILED, MAX_SCHEDULES, Schedules
from dock_gateway.extensions.missions.schema import EVENTS
from dock_gateway.extensions.missions.step_goals import StepGoals
from dock_gateway.extensions.missions.templates import routes as of_templates
from dock_gateway.extensions.missions.templates.template import TemplateEntry
from dock_gateway.extensions.missions.templates.templates import MAX_TEMPLATES, Templates
from dock_gateway.extensions.missions.tools import TOOLS
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.graph.publishing import Publishing
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.settings import Settings
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook


@asynccontextmanager
async def open_missions(parts: Parts) -> AsyncIterator[Missions]:
    """Carry out missions."""
    async with AsyncExitStack() as stack:
        robots, actions, robot_actions = parts[RobotRegistry], parts[ActionRegistry], parts[RobotActions]
        history, interlock, labels = parts[History], parts[Interlock], parts[RobotLabels]
        messages = Messages(parts[ServiceCalls], parts[Publishing])
        places, templates = _stored(parts)
        book = MissionBook(
            parts[Fanout],
            history.documents("mission", MissionEntry),
            history.documents("ended_mission", MissionEntry),
            lambda mission, grant: covers(mission, grant, robot_actions, labels.in_group),
        )
        last_stops = LastStops(history.documents("mission_stop", LastStop))
        runner = closed_by(stack, _make_runner(parts, book, messages, places, last_stops))
        _listen(parts, runner, stack)
        runner.start()
        missions = Missions(
            book,
            runner,
            robots=robots,
            actions=actions,
            robot_actions=robot_actions,
            messages=messages,
            places=places,
            templates=templates,
            interlock=interlock,
            members=labels.in_group,
            approvals=parts[Approvals],
            last_stops=last_stops,
        )
        _open_schedules(parts, missions, last_stops, stack)
        yield missions


def _make_runner(
    parts: Parts, book: MissionBook, messages: Messages, places: Places, last_stops: LastStops
) -> MissionRunner:
    actions, history, interlock, fleet = parts[ActionRegistry], parts[History], parts[Interlock], parts[Fleet]
    facts = FactsReader(
        robots=parts[RobotRegistry],
        actions=actions,
        goals=parts[Goals],
        history=history,
        places=places,
        interlock=interlock,
        last_stops=last_stops,
        docked=lambda robot: None if (state := fleet.state(robot)) is None else state.docked,
    )
    goals = StepGoals(
        book,
        actions=actions,
        robot_actions=parts[RobotActions],
        docks=parts[Docks],
        robots=parts[RobotRegistry],
        last_stops=last_stops,
    )
    return MissionRunner(
        book,
        goals=goals,
        messages=messages,
        interlock=interlock,
        share=parts[Share],
        candidates=Candidates(fleet, parts[RobotLabels], parts[Settings].low_battery, last_stops.at).read,
        last_stops=last_stops,
        facts=facts,
        shared=history.shared,
    )


def _listen(parts: Parts, runner: MissionRunner, stack: AsyncExitStack) -> None:
    """Tell missions what happens, and others what missions do, until the stack is closed."""
    actions, robots, alerts = parts[ActionRegistry], parts[RobotRegistry], parts[AlertBoard]
    book = runner.book
    for adding in (
        actions.on_end.adding(runner.on_goal),
        actions.on_lost.adding(runner.on_goal),
        parts[Stopper].on_stop.adding(runner.on_stop),
        parts[Interlock].on_release.adding(runner.on_release),
        robots.at_work.adding(runner.has_work),
        robots.on_low_battery.adding(runner.ask_to_charge),
        alerts.sources.adding(lambda: alerts_of_holds(book.all().values())),
        alerts.sources.adding(lambda: book.notices.alerts(robots.namespaces())),
    ):
        stack.enter_context(adding)


def _stored(parts: Parts) -> tuple[Places, Templates]:
    """Add what people store for missions to the parts, and return it."""
    history = parts[History]
    places = Places(SharedBook(history.documents("place", PlaceEntry), "place", MAX_PLACES))
    templates = Templates(SharedBook(history.documents("template", TemplateEntry), "template", MAX_TEMPLATES))
    return parts.add(Places, places), parts.add(Templates, templates)


def _open_schedules(parts: Parts, missions: Missions, last_stops: LastStops, stack: AsyncExitStack) -> None:
    """Queue missions by schedules."""
    store, robots = parts[History].documents("schedule", ScheduleEntry), parts[RobotRegistry]
    book = SharedBook(store, "schedule", MAX_SCHEDULES, BY_THEMSELVES)
    schedules = parts.add(Schedules, Schedules(book, missions, robots))
    stack.enter_context(parts[AlertBoard].sources.adding(schedules.alerts))
    closed_by(stack, Scheduler(book, missions, robots=robots, last_stops=last_stops, share=parts[Share])).start()


extension = Extension(
    "missions",
    open_missions,
    routes=lambda _: (router, of_places.router, of_templates.router, of_schedules.router),
    events=EVENTS,
    alerts=(NOTICE, FAILED, RETURN_FAILED, UNAPPROVED),
    errors=CODES,
    tools=TOOLS,
)
