"""One gateway and one action server around a stop: requests overtake each other, answers are lost, the server freezes.

The action, the stop and the latch are the product's own. Simulated are the server, the network and the clock.
"""

import asyncio
import random
import time
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus, ResultAnswer
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.action import Action
from dock_gateway.goals.action_context import ActionContext
from dock_gateway.goals.goal_machine import GoalChange
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.latch import interlock as latching
from dock_gateway.ros.action_link import ServerPresence
from dock_gateway.ros.action_port import CancelAnswer
from dock_gateway.ros.status import StatusReport
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from tests.support.history import HistoryInMemory
from tests.support.robot_actions import make_robot_actions
from tests.support.stopping import FakeTopic, FakeWheels

S = GoalStatus
NAME = "/dock"
# Seconds that a goal runs unless it is canceled: longer than a run.
GOAL_TAKES = 1000.0


@dataclass(frozen=True)
class Troubles:
    """What goes wrong around a stop. Times are in seconds.

    Attributes:
        latency: Of each message, at most.
        answers_lost: Share of the answers of services that are lost.
        frozen: How long the server is frozen around the stop, at most.
        latched, by_another: Whether the stop is latched, and whether it was requested at another gateway.
        released_after: How long it is latched, at most.
        refusals: Cancel requests that the server refuses for each goal, at most.
        accept_timeout: The setting.
    """

    latency: float = 0.01
    answers_lost: float = 0.0
    frozen: float = 0.0
    latched: bool = True
    by_another: bool = False
    released_after: float | None = None
    refusals: int = 0
    accept_timeout: float = 2.0


class Call:
    """A request on its way."""

    def __init__(self) -> None:
        self.response: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    def answer(self, response: Any) -> None:
        if not self.response.done():
            self.response.set_result(response)

    def forget(self) -> None:
        self.response.cancel()


class Server:
    """An action server that executes all goals, and cancels those that it knows when a request to cancel arrives.

    Attributes:
        goals: The state of each goal.
        known_at: When it accepted each.
        canceled_at: When it canceled each.
    """

    def __init__(self, draw: random.Random, troubles: Troubles) -> None:
        self._draw = draw
        self._troubles = troubles
        self._refusals: dict[str, int] = {}
        self._awake = asyncio.Event()
        self._awake.set()
        self._awaiting: dict[str, list[Call]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._status_at = 0.0
        self.goals: dict[str, GoalStatus] = {}
        self.known_at: dict[str, float] = {}
        self.canceled_at: dict[str, float] = {}
        self.on_status: Callable[[list[StatusReport], int], None] = lambda *_: None

    def freeze(self, seconds: float) -> None:
        self._awake.clear()
        asyncio.get_running_loop().call_later(seconds, self._awake.set)

    def request(self, handle: Callable[[], Any]) -> Call:
        """Send a request; those of different services overtake each other, as does each answer."""
        call = Call()

        async def carry() -> None:
            await asyncio.sleep(self._latency())
            await self._awake.wait()
            await asyncio.sleep(self._draw.uniform(0, 0.001))  # the executor takes what waits in any order
            answer = handle()
            if answer is not None and self._draw.random() >= self._troubles.answers_lost:
                await asyncio.sleep(self._latency())
                call.answer(answer)

        self._spawn(carry())
        return call

    def _spawn(self, work: Any) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _latency(self) -> float:
        return self._draw.uniform(0.0002, self._troubles.latency)

    def take(self, goal_id: str) -> Any:
        if goal_id not in self.goals:
            self.known_at[goal_id] = time.monotonic()
            self._refusals[goal_id] = self._draw.randint(0, self._troubles.refusals)
            self._set(goal_id, S.ACCEPTED)
            self._later(self._draw.uniform(0.0005, 0.05), goal_id, S.ACCEPTED, S.EXECUTING)
            self._later(GOAL_TAKES, goal_id, S.EXECUTING, S.SUCCEEDED)
        stamp = time.time_ns()
        return SimpleNamespace(accepted=True, stamp=SimpleNamespace(sec=stamp // 10**9, nanosec=stamp % 10**9))

    def cancel(self, goal_ids: Collection[str], *, every: bool) -> CancelAnswer:
        canceled = frozenset(goal_id for goal_id in goal_ids if self._cancels(goal_id))
        for goal_id in canceled:
            self.canceled_at[goal_id] = time.monotonic()
            self._set(goal_id, S.CANCELING)
            self._later(self._draw.uniform(0, 0.5), goal_id, S.CANCELING, S.CANCELED)
        if canceled or every:
            return CancelAnswer(canceled, 0)
        (goal_id,) = goal_ids
        code = 2 if goal_id not in self.goals else 0 if self._runs(goal_id) else 3
        return CancelAnswer(frozenset(), code)

    def _cancels(self, goal_id: str) -> bool:
        if not self._runs(goal_id):
            return False
        self._refusals[goal_id] -= 1
        return self._refusals[goal_id] < 0

    def _runs(self, goal_id: str) -> bool:
        return self.goals.get(goal_id) in (S.ACCEPTED, S.EXECUTING)

    def await_result(self, goal_id: str, call: Call) -> ResultAnswer | None:
        if (status := self.goals.get(goal_id)) is None or status.final:
            return ResultAnswer(status, None if status is None else b"{}")
        self._awaiting.setdefault(goal_id, []).append(call)
        return None

    def _later(self, delay: float, goal_id: str, before: GoalStatus, after: GoalStatus) -> None:
        async def change() -> None:
            await asyncio.sleep(delay)
            await self._awake.wait()
            if self.goals[goal_id] is before:
                self._set(goal_id, after)

        self._spawn(change())

    def _set(self, goal_id: str, status: GoalStatus) -> None:
        self.goals[goal_id] = status
        stamp = time.time_ns()
        reports = [StatusReport(known, state, stamp) for known, state in self.goals.items()]
        self._status_at = max(self._status_at + 1e-6, time.monotonic() + self._latency())
        asyncio.get_running_loop().call_at(self._status_at, lambda: self.on_status(reports, stamp))
        for call in self._awaiting.pop(goal_id, []) if status.final else ():
            call.answer(ResultAnswer(status, b"{}"))


class Port:
    """The action as the gateway reaches it."""

    action_name = NAME
    action_type = "pkg/action/Dock"
    listener = None
    unanswered_since = None  # no other DDS participant is tried
    answered = True
    away = False

    def __init__(self, server: Server) -> None:
        self._server = server
        self.sent: list[str] = []

    def encode_goal(self, goal: Any) -> bytes:
        return b"%d" % goal

    def send(self, goal_id: str, _: Any) -> Call:
        self.sent.append(goal_id)
        return self._server.request(lambda: self._server.take(goal_id))

    def request_result(self, goal_id: str) -> Call:
        call = self._server.request(lambda: self._server.await_result(goal_id, call))
        return call

    async def cancel(self, goal_id: str | None, timeout: float) -> CancelAnswer:
        def handle() -> CancelAnswer:
            return self._server.cancel([*self._server.goals] if goal_id is None else [goal_id], every=goal_id is None)

        async with asyncio.timeout(timeout):
            answer: CancelAnswer = await self._server.request(handle).response
        return answer

    async def presence(self) -> ServerPresence:
        return ServerPresence(available=True)

    async def ping(self, timeout: float) -> bool:
        try:
            async with asyncio.timeout(timeout):
                await self._server.request(lambda: True).response
        except TimeoutError:
            return False
        return True


class Stored:
    """Stores the latches at once, in place of `LatchWriter`."""

    problem = None

    def __init__(self, *_: Any, **__: Any) -> None:
        pass

    def put(self, _: Any) -> None:
        pass

    async def wait(self, _: float) -> bool:
        return True

    async def close(self) -> None:
        pass


class LateGoals:
    """One run: goals, a stop, and perhaps a release.

    Args:
        seed: Decides everything.
        troubles: What goes wrong.

    Attributes:
        before, after: The goals sent before a stop, and after the release.
        stopped: Those that had not ended when a stop came.
        stopped_at: When the last stop came.
        thawed_at: When the server was last frozen no longer.
        server: The action server.
    """

    def __init__(self, seed: int, troubles: Troubles) -> None:
        self._draw = draw = random.Random(seed)
        self._troubles = troubles
        self.before: set[str] = set()
        self.after: set[str] = set()
        self.stopped: set[str] = set()
        self.stopped_at = self.thawed_at = 0.0
        self._ended: list[Goal] = []
        self.server = Server(draw, replace(troubles, latency=draw.choice([0.1, 0.3, 1.0]) * troubles.latency))
        self._port: Any = Port(self.server)
        self._sending: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        port, settings = self._port, Settings(accept_timeout=self._troubles.accept_timeout, cancel_timeout=1.0)
        fanout, history = Fanout(queue_limit=10), HistoryInMemory()
        with patch.object(latching, "LatchWriter", Stored):
            file: Any = SimpleNamespace(read=dict, path=Path("/"))
            self.interlock = interlock = latching.Interlock(fanout, file)
        interlock.join("/", FakeTopic())
        bridge: Any = None
        robot: Any = SimpleNamespace(namespace="/", wheels=FakeWheels())
        robots: Any = SimpleNamespace(place=lambda _=None: "/", under=lambda _: [robot])
        actions = ActionRegistry(
            settings,
            bridge,
            fanout,
            history,
            PendingFacts(0.05),
            interlock=interlock,
            robots=robots,
            robot_actions=make_robot_actions(settings),
        )
        self.action = Action(port, ActionContext(settings, fanout, history, PendingFacts(0.05), interlock))
        actions._actions[NAME] = self.action  # noqa: SLF001 - no ROS graph has it
        self.server.on_status = self.action.tracker.on_status
        self.action.tracker.on[GoalChange.RETIRED].append(self._ended.append)
        self.stopper = Stopper(robots, actions, interlock)
        await asyncio.sleep(2.0)  # the server is known to answer
        await self._go_through()
        await asyncio.sleep(100.0)
        await self.stopper.close()
        await actions.close()
        await interlock.close()

    async def _go_through(self) -> None:
        draw, troubles = self._draw, self._troubles
        for _ in range(draw.randint(1, 4)):
            self._send()
            await asyncio.sleep(draw.uniform(0, 0.3))
        if troubles.frozen:
            frozen = draw.uniform(0, troubles.frozen)
            self.server.freeze(frozen)
            self.thawed_at = time.monotonic() + frozen
            self._send()
            await asyncio.sleep(draw.choice([0.0, 0.001, 0.1, 3.0]))
        await self._stop()
        while draw.random() < 0.4:  # what comes between two stops is sent only if the first is not latched
            self._send()
            await asyncio.sleep(draw.choice([0.0, 0.01, 0.3]))
            await self._stop()
        if troubles.released_after is not None:
            await asyncio.sleep(draw.uniform(0, troubles.released_after))
            await self.stopper.release()
        if not self.interlock.holds(NAME) and not troubles.answers_lost:  # else it may be given up, and canceled
            await asyncio.sleep(max(0.0, self.thawed_at - time.monotonic()) + 2.0)
            sent = len(self._port.sent)
            self._send()
            await asyncio.sleep(0.01)
            self.after.update(self._port.sent[sent:])

    def _send(self) -> None:
        async def send() -> None:
            with suppress(GatewayError):
                await self.action.submitter.submit(1, sender=ANYBODY)

        task = asyncio.create_task(send())
        self._sending.add(task)
        task.add_done_callback(self._sending.discard)

    async def _stop(self) -> None:
        self.before.update(self._port.sent)
        self.stopped.update(self.action.tracker.live)
        self.stopped_at = time.monotonic()
        if self._troubles.by_another:
            self.server.request(lambda: self.server.cancel([*self.server.goals], every=True))
            self.interlock.heard("/", latched=True, received=time.monotonic())
        else:
            await self.stopper.stop(latch=self._troubles.latched)
        self.before.update(self._port.sent)

    # ------------------------------------------------------------------ what must hold

    def found(self) -> list[str]:
        """Return what is wrong: goals sent before the stop that run or do not say why, and others that do not run."""
        states = self.server.goals
        found = [f"{goal} runs, though it was sent before the stop" for goal in self.before if self._runs(goal)]
        ended = {goal for goal in self.after & states.keys() if not self._runs(goal)}
        found += [f"{goal} was sent after the release, and is {states[goal].value}" for goal in ended]
        if not self._troubles.by_another:  # whose gateway knows why
            canceled = {goal.goal_id for goal in self._ended if goal.status is S.CANCELED and goal.error is None}
            found += [f"{goal} was canceled and does not say why" for goal in canceled & self.stopped]
        tracked = [goal for goal in self.action.tracker.running() if not self._runs(goal.goal_id)]
        return found + [f"{goal.goal_id} counts as {goal.status.value}" for goal in tracked]

    def _runs(self, goal_id: str) -> bool:
        return self.server.goals.get(goal_id) in (S.ACCEPTED, S.EXECUTING)

    def took(self) -> list[float]:
        """Return how long it took to cancel each goal: since the stop, its acceptance, and the end of the freezing."""
        return [
            at - max(self.stopped_at, self.server.known_at[goal_id], self.thawed_at)
            for goal_id, at in self.server.canceled_at.items()
        ]

    def late(self) -> int:
        """Return how many goals were accepted after the stop."""
        return sum(self.server.known_at.get(goal, 0.0) > self.stopped_at for goal in self.before)
