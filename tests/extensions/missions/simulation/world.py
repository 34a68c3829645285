"""One run: robots and docks, gateways on one database, people, and what goes wrong. One seed decides everything."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable, Coroutine
from datetime import UTC, datetime
from functools import partial
from typing import Any

from dock_gateway.core.filters import is_under
from dock_gateway.core.goal import Goal
from dock_gateway.extension_list import OURS
from dock_gateway.extensions.missions.mission import MissionStatus
from dock_gateway.extensions.missions.moves import WaitsFor
from tests.dock_gateway.simulation.chance import Chance
from tests.dock_gateway.simulation.database import Disk
from tests.dock_gateway.simulation.process import noted
from tests.extensions.missions.simulation.checks import Checks
from tests.extensions.missions.simulation.gateway import HAS_RULES, SHARES_DOCKS, Gateway, StoredLatches
from tests.extensions.missions.simulation.people import People
from tests.extensions.missions.simulation.robot import Docks, Robot
from tests.extensions.missions.simulation.rule_checks import BELOW, IDLE
from tests.extensions.missions.simulation.server import Server
from tests.extensions.missions.simulation.stored import share_docks, share_groups, store_rule
from tests.extensions.missions.simulation.troubles import HOUR, Troubles
from tests.support.virtual import START_NS

# Seconds for which missions may take to end once nothing goes wrong any more.
SETTLES_WITHIN = 4 * HOUR


class World:
    """One run.

    Args:
        seed: Decides everything.
        disk: The database.
        troubles: What goes wrong.

    Attributes:
        gateways: Those that run.
        people: What people do.
        groups: The robots of each group.
        shares_docks: Whether a dock has one robot at most.
        ruled: The robots that a rule docks when their battery is low.
        calm_since: Since when nothing has been in the way of each robot.
        gateways_since: Since when one gateway ran at least, and none was killed.
    """

    def __init__(self, seed: int, disk: Disk, troubles: Troubles) -> None:
        self.troubles = troubles
        self.disk = disk
        self.chance = Chance(seed, troubles)
        self._random = self.chance.random
        self.checks = Checks(self)
        self.docks = Docks(self._random, troubles.docks, troubles.waiting_places)
        self.names = [f"/r{index}" for index in range(troubles.robots)]
        self.robots = {name: self._make_robot(name) for name in self.names}
        self.groups = {"all": self.names, "two": self.names[:2]}
        self.servers = {server.name: server for robot in self.robots.values() for server in robot.servers.values()}
        self.gateways: list[Gateway] = []
        self.calm_since = dict.fromkeys(self.names, 0.0)
        self.gateways_since = 0.0
        self.people = People(self)
        self._files: defaultdict[str, StoredLatches] = defaultdict(StoredLatches)
        self._spools: defaultdict[str, dict[int, list[bytes]]] = defaultdict(dict)
        self.shares_docks = SHARES_DOCKS in OURS
        self.ruled = self.names[: troubles.rules] if HAS_RULES in OURS else []
        self._troubled = True

    @property
    def time(self) -> float:
        """Seconds since the run began."""
        return self.chance.loop.time()

    def time_of(self, moment: datetime | None) -> float:
        """Return a moment as `time`; 0.0: there is none."""
        return 0.0 if moment is None else moment.timestamp() - START_NS / 1e9

    def fault(self, what: str) -> None:
        """Note that something is wrong."""
        self.checks.fault(what)

    def disturbed_at(self, robot: str) -> float:
        """Return when something was last in the way of a robot, or of the gateways."""
        return max(self.calm_since[robot], self.gateways_since)

    def is_calm(self, robot: str, since: float, seconds: float) -> bool:
        """Return whether nothing has been in their way since a time, for so many seconds at least."""
        return self.time - max(since, self.disturbed_at(robot)) > seconds

    def now(self) -> datetime:
        """Return the time."""
        return datetime.fromtimestamp(self.chance.loop.time_ns() / 1e9, UTC)

    def _make_robot(self, name: str) -> Robot:
        lost, speed = self.troubles.answers_lost, self.troubles.battery_speed
        navigating = self._random.random() < self.troubles.navigating
        return Robot(
            self.chance,
            name,
            self.docks,
            self.checks.accepted,
            answers_lost=lost,
            battery_speed=speed,
            navigating=navigating,
        )

    # ------------------------------------------------------------------ the run

    async def run(self) -> None:
        """Let everything happen, then wait until all missions have ended, and check them."""
        self.chance.loop.set_task_factory(noted)
        with self.chance.deciding_ids():
            await self._run()

    async def _run(self) -> None:
        self.disk.empty()
        if self.shares_docks:
            share_docks(self.disk, self.docks.places, self.now())
        if self.ruled:
            store_rule(self.disk, self.ruled, BELOW, IDLE, self.now())
        share_groups(self.disk, self.groups)
        for name in "ABC"[: self.troubles.gateways]:
            self._start(name)
        await asyncio.sleep(2.0)
        await self.people.store_template()
        troubles = self.troubles
        work = [
            *(self._often(troubles.missions_every, partial(self.people.queue, robot)) for robot in self.names),
            self._often(troubles.groups_every, self.people.queue_for_group),
            self._often(troubles.people_every, self.people.meddle),
            self._often(troubles.stops_every, self.people.stop),
            self._often(troubles.goals_every, self.people.send_goal),
            self._often(troubles.kills_every, self._kill),
            self._often(troubles.servers_every, self._break_server),
            self._often(troubles.docks_every, self._block_dock),
            self._often(troubles.repairs_every, self.people.repair_docks),
            self._often(troubles.batteries_every, self.people.change_batteries),
        ]
        if self.ruled:
            work.append(self._often(troubles.holds_every, self.people.continue_rule))
        work += map(self.people.store_schedule, self.names[: troubles.schedules])
        for each in work:
            self.chance.spawn(self._noting(each))
        self.chance.spawn(self._noting(self._watch_robots()))
        until = self.time + troubles.lasts
        while self.time < until:
            await asyncio.sleep(60.0)
            self.checks.look()
        await self._settle()
        self.checks.check_all()

    async def _watch_robots(self) -> None:
        while True:
            await asyncio.sleep(2 * self.troubles.look_every)
            now = self.time
            for robot in self.robots.values():
                if robot.charge <= 0 and robot.on:
                    self.chance.say("world", f"the battery of {robot.name} is empty")
                    robot.switch_off()
                servers = robot.servers.values()
                held = any(robot.name in file.held or "/" in file.held for file in self._files.values())
                if not robot.there or held or not all(server.up and server.awake.is_set() for server in servers):
                    self.calm_since[robot.name] = max(now, self.calm_since[robot.name])
            if not any(gateway.ready and not gateway.dead for gateway in self.gateways):
                self.gateways_since = now
            self.checks.look_at_robots()

    async def _noting(self, work: Coroutine[Any, Any, None], gateway: Gateway | None = None) -> None:
        """Note an error of the simulation itself, or of a gateway that was not killed."""
        try:
            await work
        except Exception as error:  # noqa: BLE001 - whatever it is, the run shows nothing then
            if gateway is not None and gateway.dead:
                return
            self.fault(f"the simulation failed: {error!r}")

    async def _often(self, every: float, do: Callable[[], Awaitable[None]]) -> None:
        while self._troubled:
            await asyncio.sleep(self._random.expovariate(1 / every))
            if self._troubled:
                await do()

    async def _settle(self) -> None:
        """Let nothing go wrong any more; people continue what is held, until all missions have ended."""
        self._troubled = False
        self.chance.say("world", "settles")
        self.docks.blocked.clear()
        for robot in self.robots.values():
            robot.mend()
            robot.change_battery()
        began = self.time
        while self.time - began < SETTLES_WITHIN:
            await asyncio.sleep(60.0)
            self.checks.look()
            if not any(gateway.ready and not gateway.dead for gateway in self.gateways):
                continue
            await self.people.release(None)
            await self.people.remove_schedules()
            await self.people.clear_docks()
            await self.people.repair_docks()
            await self.people.change_batteries()
            missions = self.checks.stored()
            if not missions and self.checks.added.keys() == self.checks.ended.keys():
                return
            for mission_id, mission in missions.items():
                if mission.in_queue and self._random.random() < 0.05:
                    await self.people.cancel(mission_id, mission)
                elif mission.status is MissionStatus.HELD:
                    await self.people.go_on(mission_id, mission)
                elif self._waits_for(mission_id, WaitsFor.LOST_GOAL):
                    await self.people.cancel(mission_id, mission)
                elif self._waits_for(mission_id, WaitsFor.CONTINUE):
                    await self.people.go_on(mission_id, mission)

    def _waits_for(self, mission_id: str, reason: WaitsFor) -> bool:
        """Return whether a gateway says that a mission waits for something."""
        return reason in (gateway.missions.book.waits.get(mission_id) for gateway in self.gateways if gateway.ready)

    def goals_on(self, robot: str) -> list[Goal]:
        """Return the goals on a robot that gateways follow."""
        ready = [gateway for gateway in self.gateways if gateway.ready and not gateway.dead]
        goals = [goal for gateway in ready for goal in (*gateway.actions.running(), *gateway.actions.lost())]
        return [goal for goal in goals if is_under(goal.action_name, robot)]

    # ------------------------------------------------------------------ gateways

    def _start(self, name: str) -> None:
        gateway = Gateway(self, name, self._files[name], self._spools[name])
        self.gateways = [other for other in self.gateways if not other.dead] + [gateway]
        self.gateways_since = self.time
        gateway.spawn(self._noting(gateway.run(), gateway))

    def on_killed(self, gateway: Gateway) -> None:
        """A gateway was killed; it starts again."""
        self.checks.counts["kills"] += 1
        self.gateways_since = self.time
        self.chance.later(
            self._random.choice([0.5, 5.0, self._random.uniform(5, 120)]), lambda: self._start(gateway.name)
        )

    async def _kill(self) -> None:
        victim = self._random.choice(self.gateways)
        victim.kill()

    def is_spooled(self, goal_id: str) -> bool:
        """Return whether a goal is in the spool of a gateway, which has no answer of the database yet."""
        lines = (line for files in self._spools.values() for spooled in files.values() for line in spooled)
        return any(goal_id.encode() in line for line in lines)

    def tell_latch(self, sender: Gateway, namespace: str, *, latched: bool) -> None:
        """Bring what one gateway has published on `stop_latched` to the others."""
        for gateway in self.gateways:
            if gateway is not sender and gateway.joined and not gateway.dead:
                self._bring_latch(gateway, namespace, latched=latched)

    def tell_latches_to(self, gateway: Gateway) -> None:
        """Bring what others have last published on `stop_latched` to a new gateway."""
        for other in self.gateways:
            if other is not gateway and not other.dead:
                for namespace, latched in other.latched.items():
                    self._bring_latch(gateway, namespace, latched=latched)

    def _bring_latch(self, gateway: Gateway, namespace: str, *, latched: bool) -> None:
        def arrive() -> None:
            if not gateway.dead:
                with gateway.running():
                    gateway.interlock.heard(namespace, latched=latched, received=self.time)

        self.chance.later(self.chance.latency(), arrive)

    # ------------------------------------------------------------------ what robots are sent

    def on_send(self, gateway: Gateway, server: Server, goal_id: str, message: dict[str, Any]) -> None:
        """A gateway sends a goal."""
        self.chance.say(gateway.name, f"sends {goal_id} {message} to {server.name}")
        self.checks.sent_at[goal_id] = self.time
        self.checks.sent(gateway, server.robot.name, message)

    def on_call(self, gateway: Gateway, service: str, request: dict[str, Any]) -> None:
        """A gateway calls a service."""
        self.chance.say(gateway.name, f"calls {service} {request}")
        self.checks.called(gateway, service.rpartition("/")[0], request)

    # ------------------------------------------------------------------ what breaks

    async def _break_server(self) -> None:
        robot = self.robots[self._random.choice(self.names)]
        server = self._random.choice([*robot.servers.values()])
        kind = self._random.choice(["end", "freeze", "off", "out of reach"])
        takes = self._random.choice([1.0, 5.0, 20.0, self._random.uniform(20, 600)])
        if not robot.there or not server.up:
            return
        self.chance.say("world", f"{kind} {robot.name} {server.name} for {takes:.0f} s")
        self.calm_since[robot.name] = self.time + takes
        if kind == "freeze":
            self.checks.lost_sight(robot)
            server.freeze(takes)
        elif kind == "end":
            server.end()
            self.chance.later(takes, server.start)
        elif kind == "off":
            robot.switch_off()
            self.chance.later(takes, robot.switch_on)
        else:
            self.checks.lost_sight(robot)
            robot.in_reach = False
            self.chance.later(takes, robot.reach)

    async def _block_dock(self) -> None:
        dock = self._random.choice(self.docks.names)
        self.docks.blocked.add(dock)
        self.chance.later(self._random.uniform(60, 1200), lambda: self.docks.blocked.discard(dock))

    def story(self) -> str:
        """Return what has happened."""
        return "\n".join(f"{at:10.3f} {who:8} {what}" for at, who, what in self.chance.said)
