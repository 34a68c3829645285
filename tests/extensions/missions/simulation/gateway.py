"""One life of a gateway: the product's own goals, stops, history and missions, on a simulated network and database."""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import AsyncExitStack, ExitStack, contextmanager
from dataclasses import replace
from datetime import UTC, datetime, timedelta, tzinfo
from functools import lru_cache, partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

from pydantic import TypeAdapter

from dock_gateway.core.errors import NotFound, ServerTimeout
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.listeners import Hooks
from dock_gateway.core.share import EVERYTHING, Share
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.extension import find_extension
from dock_gateway.extension_list import OURS
from dock_gateway.extensions.missions import book, extension, runner
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.schedules import scheduler
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.fleet.fleet import Fleet
from dock_gateway.fleet.graph_watch import GraphWatch
from dock_gateway.goals import action, registry, rejoining
from dock_gateway.goals.approvals import Approvals
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.goals.unfinished import take_over_unfinished
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.publishing import Publishing
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latches import Latch
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.robots import RobotLabels
from dock_gateway.ros.graph import Scan
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History, entries, shared_entries, writer
from dock_gateway.storage import history as history_module
from tests.dock_gateway.simulation.database import Disk, SimulatedDatabase, SimulatedSpool
from tests.dock_gateway.simulation.gateway import FOREVER
from tests.dock_gateway.simulation.process import Process
from tests.extensions.missions.simulation.known_robots import KnownDocks, KnownFleet, KnownRobots
from tests.extensions.missions.simulation.port import Bridge, Port
from tests.extensions.missions.simulation.server import Server
from tests.extensions.missions.simulation.troubles import Troubles

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.world import World


# The extension that lets a dock have one robot, if it is there.
SHARES_DOCKS = "chargers"
# The one that has rules by which robots dock by themselves, if it is there.
HAS_RULES = "automation"


class FragileDatabase(SimulatedDatabase):
    """A database, right before and after whose writes a gateway may be killed."""

    def __init__(self, disk: Disk, gateway: "Gateway") -> None:
        super().__init__(disk, gateway, gateway.chance.database_delay, shared=gateway.troubles.gateways > 1)
        self._gateway = gateway

    async def write(  # type: ignore[override]
        self, work: Callable[..., Any], *args: Any, durable: bool = True
    ) -> Any:
        chance, share = self._gateway.chance, self._gateway.troubles.kills_at_writes
        if chance.random.random() < share / 2:
            self._gateway.kill()
        found = await super().write(self._noting(work), *args, durable=durable)
        if chance.random.random() < share / 2:
            self._gateway.kill()
        return found

    def _noting(self, work: Callable[..., Any]) -> Callable[..., Any]:
        """Let what is written be looked at in the same transaction."""

        def write(connection: Any, *args: Any) -> Any:
            found = work(connection, *args)
            self._gateway.world.checks.groups.on_write(connection)
            return found

        return write


class LatchTopic:
    """`stop_latched` of a robot, as one gateway publishes it."""

    def __init__(self, gateway: "Gateway", namespace: str) -> None:
        self._gateway = gateway
        self._namespace = namespace

    def publish(self, *, latched: bool) -> None:
        self._gateway.latched[self._namespace] = latched
        self._gateway.world.tell_latch(self._gateway, self._namespace, latched=latched)

    async def withdraw(self) -> None:
        self._gateway.latched.pop(self._namespace, None)

    def held_by(self) -> str | None:
        return None

    def let_go(self) -> None:
        pass


class StoredLatches:
    """The file of the latches, which outlives the gateway."""

    path = Path("/latches")

    def __init__(self) -> None:
        self.held: dict[str, Latch] = {}

    def read(self) -> dict[str, Latch]:
        return dict(self.held)

    def write(self, held: dict[str, Latch]) -> None:
        self.held = dict(held)


class Services:
    """Services, each of which takes a second, and notes its calls with the world."""

    def __init__(self, gateway: "Gateway") -> None:
        self._gateway = gateway
        self.listed = SimpleNamespace(require=lambda _: None)

    async def find(self, *_: Any) -> Any:
        raise NotFound("it may come later")

    async def call(self, service: str, request: Any, *, type_name: Any, timeout: float) -> None:
        if self._gateway.dead:
            raise OSError("killed")
        self._gateway.world.on_call(self._gateway, service, request)
        self._gateway.may_be_killed()
        await asyncio.sleep(self._gateway.chance.random.uniform(0.01, 1.0))
        if self._gateway.chance.random.random() < 0.1:
            raise ServerTimeout("no answer")


class Gateway(Process):
    """One life of a gateway.

    Args:
        world: What is around it.
        name: Of the gateway, the same in each of its lives.
        file: Its latches.

    Attributes:
        missions: Its missions, once it is ready.
        rules: Its rules, if it has any.
        latched: What it has published on `stop_latched`, by robot.
        joined: Whether it hears others there.
        ready_at: When it was ready.
    """

    missions: Missions
    rules: Any
    actions: ActionRegistry
    stopper: Stopper

    def __init__(self, world: "World", name: str, file: StoredLatches, spool: dict[int, list[bytes]]) -> None:
        super().__init__(world.chance, name)
        self.world = world
        self.troubles: Troubles = world.troubles
        self.servers: dict[str, Server] = world.servers
        self.latched: dict[str, bool] = {}
        self.joined = False
        self.ready_at = 0.0
        self._file = file
        self._spool = spool

    def kill(self) -> None:
        if not self.dead:
            super().kill()
            for server in self.servers.values():
                server.readers = [reader for reader in server.readers if reader.gateway is not self]
            self.world.on_killed(self)

    def may_be_killed(self) -> None:
        """Be killed by chance, right after something was sent."""
        if self.chance.random.random() < self.troubles.kills_at_sends:
            self.chance.later(self.chance.random.choice([0.0, 0.002, 0.01, 0.5]), self.kill)

    async def run(self) -> None:
        """Open the gateway, and run until it is killed."""
        database, spool = FragileDatabase(self.world.disk, self), SimulatedSpool(self._spool)
        with patch("dock_gateway.storage.history.open_database", lambda _: database):
            history = History("", spool, max_waiting=1000, limits=replace(FOREVER, interval=1e6))  # type: ignore[arg-type]
        await history.open()
        parts, robots = self._make_parts(history)
        await parts[Fleet].open(history)
        await parts[Labels].open()
        self.parts = parts
        self.actions, self.stopper = parts[ActionRegistry], parts[Stopper]
        asyncio.create_task(take_over_unfinished(self.actions, history))  # noqa: RUF006 - noted
        for name in robots.namespaces():
            parts[Interlock].join(name, LatchTopic(self, name))
        self.joined = True
        self.world.tell_latches_to(self)
        asyncio.create_task(self._scan())  # noqa: RUF006 - noted
        async with AsyncExitStack() as stack:
            if HAS_RULES in OURS:
                self.rules = await stack.enter_async_context(find_extension(HAS_RULES).open(parts))
            if SHARES_DOCKS in OURS:
                await stack.enter_async_context(find_extension(SHARES_DOCKS).open(parts))
            self.missions = await stack.enter_async_context(extension.open_missions(parts))
            self.ready, self.ready_at = True, self.chance.loop.time()
            self.chance.say(self.name, "ready")
            await asyncio.Event().wait()

    def _make_parts(self, history: History) -> tuple[Parts, KnownRobots]:
        look = self.troubles.look_every
        settings = Settings(
            namespace=self.world.names[0], ping_interval=look, stalled_after=3 * look, lost_after=8 * look
        )
        bridge: Any = Bridge(self)
        fanout, robots = Fanout(queue_limit=10), KnownRobots(self.world.robots, bridge)
        file: Any = self._file
        self.interlock = interlock = Interlock(fanout, file)
        labels = Labels(history.documents("label", RobotLabel), robots.namespaces, sync_interval=1e6)
        known: Any = robots
        robot_actions = RobotActions(settings, known, labels, history)
        actions = ActionRegistry(
            settings,
            bridge,
            fanout,
            history,
            PendingFacts(0.05),
            interlock=interlock,
            robots=known,
            robot_actions=robot_actions,
        )
        parts: dict[type, Any] = {
            Settings: settings,
            Fanout: fanout,
            History: history,
            Interlock: interlock,
            Labels: labels,
            RobotLabels: labels,
            RobotRegistry: robots,
            Fleet: KnownFleet(self.world.robots, robots, actions, labels, interlock),
            Approvals: SimpleNamespace(needs=lambda *_: False),
            RobotActions: robot_actions,
            ActionRegistry: actions,
            Goals: Goals(actions, robot_actions, history),
            Docks: KnownDocks(self.world.docks.names),
            ServiceCalls: Services(self),
            Publishing: SimpleNamespace(),
            Share: EVERYTHING,
            Stopper: Stopper(known, actions, interlock),
            AlertBoard: SimpleNamespace(sources=Hooks()),
            Relays: None,  # where the docks are is not known
            GraphCache: None,
            GraphWatch: SimpleNamespace(shared=frozenset()),
        }
        return Parts(parts), robots

    async def _scan(self) -> None:
        """Read the ROS graph again and again."""
        while True:
            there = {name: [server.action_type] for name, server in self.servers.items() if server.there}
            await self.actions.update(Scan(actions=there))
            await asyncio.sleep(self.troubles.scan_every)


class Remembering:
    """Reads stored entries, each version once: that takes a quarter of the time of a run otherwise."""

    def __init__(self, model: Any) -> None:
        adapter = TypeAdapter(model)
        self.dump_json = adapter.dump_json
        self.validate_json = lru_cache(maxsize=2000)(adapter.validate_json)


class VirtualDatetime(datetime):
    """A time of day that is that of the simulation."""

    @classmethod
    def now(cls, tz: tzinfo | None = None) -> Any:
        """Return the virtual time, as a plain datetime."""
        loop: Any = asyncio.get_running_loop()
        return datetime.fromtimestamp(loop.time_ns() / 1e9, tz or UTC)


@contextmanager
def simulated(troubles: Troubles) -> Iterator[None]:
    """Let everything have the time of the simulation, and reach simulated servers."""
    with ExitStack() as stack:
        for module, name, value in (
            (registry, "ActionPort", Port),
            (registry, "ActionKind", lambda name: SimpleNamespace(name=name)),
            (action, "FORGET_AFTER", max(action.FORGET_AFTER, 2 * troubles.scan_every)),
            (rejoining, "INTERVAL", 1e6),
            (runner, "INTERVAL", troubles.look_every),
            (runner, "SYNC_INTERVAL", 2 * troubles.look_every),
            (shared_entries, "SYNC_INTERVAL", 2 * troubles.look_every),
            (entries, "TypeAdapter", Remembering),
            (history_module, "POLL_INTERVAL", 2 * troubles.look_every),
            (writer, "SPOOL_INTERVAL", 2.0),
            (scheduler, "INTERVAL", troubles.look_every),
            (scheduler, "SYNC_INTERVAL", 2 * troubles.look_every),
            (book, "MAX_ENDED", 50),
        ):
            stack.enter_context(patch.object(module, name, value))
        if SHARES_DOCKS in OURS:
            watch = import_module(f"dock_gateway.extensions.{SHARES_DOCKS}.watch")
            stack.enter_context(patch.object(watch, "INTERVAL", troubles.look_every))
            stack.enter_context(patch.object(watch, "SYNC_INTERVAL", 2 * troubles.look_every))
            policy = import_module(f"dock_gateway.extensions.{SHARES_DOCKS}.policy")
            asks_within = max(policy.ASKS_WITHIN, timedelta(seconds=3 * troubles.look_every))
            stack.enter_context(patch.object(policy, "ASKS_WITHIN", asks_within))
        if HAS_RULES in OURS:
            rules: Any = import_module(f"dock_gateway.extensions.{HAS_RULES}.extension")
            docking = partial(rules.AutomaticDocking, interval=troubles.look_every)
            stack.enter_context(patch.object(rules, "AutomaticDocking", docking))
        stack.enter_context(patch("dock_gateway.core.event.datetime", VirtualDatetime))
        yield
