"""Gateways on one database, an action server, and a reader that moves between them, in one process.

All that a gateway does with goals, events and its database is the product's own code. Simulated are the network, whose
messages take their time, the database's delays, and the kills. One random seed decides everything.
"""

import asyncio
import itertools
from collections import Counter, defaultdict
from collections.abc import Coroutine, Sequence
from typing import Any

from dock_gateway.core.event import event_id
from tests.dock_gateway.simulation.chance import Chance, Faults, short
from tests.dock_gateway.simulation.database import Disk
from tests.dock_gateway.simulation.gateway import ACTIONS, Gateway
from tests.dock_gateway.simulation.process import Process, noted
from tests.dock_gateway.simulation.reader import Reader
from tests.dock_gateway.simulation.server import ActionServer
from tests.support.virtual import START_NS


class World:
    """One run.

    Args:
        seed: Decides everything.
        disk: The database.
        faults: What goes wrong.
    """

    def __init__(self, seed: int, disk: Disk, faults: Faults) -> None:
        self._disk = disk
        self._faults = faults
        self._chance = chance = Chance(seed, faults)
        self._random = chance.random
        self.server = ActionServer(chance)
        self.reader = Reader(chance, self._readable, event_id(START_NS, "s", "none"))
        self._gateways: list[Gateway] = []
        self._spools: defaultdict[str, dict[int, list[bytes]]] = defaultdict(dict)

    # ------------------------------------------------------------------ the run

    async def run(self) -> None:
        self._chance.loop.set_task_factory(noted)
        with self._chance.deciding_ids():
            await self._begin()
            self._chance.spawn(self.reader.run())
            self._chance.spawn(self._publish_batteries())
            await asyncio.sleep(0.2)
            await asyncio.gather(self._send_goals(), self._make_move(), *self._trouble())
            await self._settle()

    async def _begin(self) -> None:
        self._disk.empty()
        for name in "ABC"[: self._faults.gateways]:
            await self._start(name)

    def _readable(self) -> Sequence[Process]:
        """Return what readers may read from."""
        return self._gateways

    def _trouble(self) -> list[Coroutine[Any, Any, None]]:
        return [self._kill(), self._make_lag()]

    def _make_gateway(self, name: str) -> Gateway:
        return Gateway(self._chance, self.server, self._disk, self._spools[name], name)

    async def _start(self, name: str) -> None:
        gateway = self._make_gateway(name)
        self._gateways = [other for other in self._gateways if not other.dead] + [gateway]
        await gateway.spawn(gateway.start())

    async def _send_goals(self) -> None:
        for number in range(self._faults.goals):
            await asyncio.sleep(self._random.uniform(0.0, 0.3))
            goal_id, action = f"00000000-0000-4000-8000-{number:012}", self._random.choice(ACTIONS)
            while not (able := [each for each in self._gateways if not each.dead and action in each.heard]):  # noqa: ASYNC110 - there is no event for it
                await asyncio.sleep(0.05)
            gateway = self._random.choice(able)
            self._chance.say(gateway.name, f"sends {goal_id} to {action}")
            gateway.spawn(gateway.send(goal_id, action))

    async def _publish_batteries(self) -> None:
        while True:
            await asyncio.sleep(self._random.uniform(0.01, 0.1))
            stamp = self._chance.loop.time_ns()
            for gateway in self._gateways:
                if gateway.ready and not gateway.dead:
                    gateway.carry("battery", lambda to=gateway, stamp=stamp: to.on_battery(stamp))

    async def _kill(self) -> None:
        for _ in range(self._faults.kills):
            await asyncio.sleep(self._random.uniform(0.0, 1.2))
            victim = self._random.choice(self._gateways)
            if not victim.dead and victim.ready:
                victim.kill()
                self.reader.move()
                await asyncio.sleep(self._random.uniform(0.0, 0.3))
                await self._start(victim.name)

    async def _make_move(self) -> None:
        for _ in range(self._faults.moves):
            await asyncio.sleep(self._random.uniform(0.0, 1.5))
            self.reader.move()

    async def _make_lag(self) -> None:
        for _ in range(2):
            await asyncio.sleep(self._random.uniform(0.0, 1.2))
            self._chance.lag(self._random.choice(self._gateways).name)

    async def _settle(self) -> None:
        """Wait until all is told, or nothing more can come."""
        for _ in range(600):
            await asyncio.sleep(0.1)
            if self._all_told():
                await asyncio.sleep(0.5)  # enough for one that comes twice, and for a goal that is on its way
                if self._all_told():
                    return

    def _all_told(self) -> bool:
        told = {goal for _, _, kind, goal in self.reader.seen if kind == "result succeeded"}
        return self.server.idle and told == self.server.goals.keys()

    # ------------------------------------------------------------------ what must hold

    def faults_found(self) -> list[str]:
        """What is wrong with what the reader got."""
        found = []
        seen = self.reader.seen
        results = Counter(goal for _, _, kind, goal in seen if kind == "result succeeded")
        states = Counter(goal for _, _, kind, goal in seen if kind == "status succeeded")
        for goal in self.server.goals:
            for what, count in (("result", results[goal]), ("status", states[goal])):
                if count != 1:
                    found.append(f"the {what} of {goal} was told {count} times")
        if self._faults.gateways > 1:
            found += self._faults_of_states()
        for (_, before, _, _), (_, identity, _, _) in itertools.pairwise(seen):
            if identity <= before:
                found.append(f"{short(identity)} came after {short(before)}")
        if self.reader.notices["gap"]:
            found.append("a gap was told")
        return found

    def _faults_of_states(self) -> list[str]:
        """What is wrong with the states of goals: each is told once, whichever gateway noticed it."""
        told = Counter(identity for _, identity, _, _ in self.reader.seen)
        stored = self._disk.states()
        found = [f"{short(each)} is stored, and was told {told[each]} times" for each in stored if told[each] != 1]
        states = Counter((goal, kind) for _, _, kind, goal in self.reader.seen)
        first = ("status pending", "status accepted", "status executing")
        found += [f"{kind} of {goal} was told again" for (goal, kind), n in states.items() if kind in first and n > 1]
        if not self._faults.stall:  # else a goal may be in its gateway's spool first, which is as if it were away
            unsent = [goal for goal in self.server.goals if not states[goal, "status pending"]]
            found += [f"{goal} was not told to be pending" for goal in unsent]
        return found

    def story(self) -> str:
        return "\n".join(f"{at * 1000:10.3f} {who:7} {what}" for at, who, what in self._chance.said)
