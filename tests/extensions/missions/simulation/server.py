"""One action server of a simulated robot: it runs goals as it likes, and notes what it has really been sent."""

import asyncio
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Protocol

from dock_gateway.core.goal import GoalStatus, ResultAnswer
from dock_gateway.ros.action_port import CancelAnswer
from dock_gateway.ros.status import StatusReport

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.robot import Robot

S = GoalStatus
# Goals that have ended, of which the server still tells.
REMEMBERED = 5
REFUSED_GOAL, UNKNOWN_GOAL, ENDED_GOAL = 1, 2, 3


class Call:
    """A request on its way."""

    def __init__(self) -> None:
        self.response: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    def answer(self, response: Any) -> None:
        if not self.response.done():
            self.response.set_result(response)

    def forget(self) -> None:
        self.response.cancel()


class Reader(Protocol):
    """An action as one gateway reaches it.

    Attributes:
        gateway: The gateway.
    """

    gateway: Any

    def carry(self, message: Callable[[], object]) -> None:
        """Bring a message to the gateway; messages arrive in their order."""

    def on_status(self, reports: list[StatusReport], stamp_ns: int) -> None:
        """Take the states of the goals."""


@dataclass
class CarriedOut:
    """A goal that a robot has accepted.

    Attributes:
        goal_id: Its id.
        message: What it asks for.
        at: When it was accepted.
        ended_at: When it had ended, or the robot or its server had.
        hangs: Whether it never ends by itself.
    """

    goal_id: str
    message: dict[str, Any]
    at: float
    status: GoalStatus = S.ACCEPTED
    ended_at: float | None = None
    hangs: bool = False
    awaiting: list[Callable[[ResultAnswer], None]] = field(default_factory=list)
    task: "asyncio.Task[None] | None" = None

    @property
    def tag(self) -> str | None:
        """The step of a mission that it is of; None: somebody's own."""
        return self.message.get("tag")

    @property
    def runs(self) -> bool:
        """Whether the robot carries it out now."""
        return self.ended_at is None


class Server:
    """An action server.

    Args:
        robot: Its robot.
        kind: What it does: dock, undock or work.
        name: Of the action.
        action_type: Of the action.

    Attributes:
        up: Whether it is there.
        goals: Those that it knows.
        readers: The gateways that listen.
    """

    def __init__(self, robot: "Robot", kind: str, name: str, action_type: str) -> None:
        self.robot = robot
        self.kind = kind
        self.name = name
        self.action_type = action_type
        self.up = True
        self.awake = asyncio.Event()
        self.awake.set()
        self.goals: dict[str, CarriedOut] = {}
        self.readers: list[Reader] = []
        self._chance = robot.chance

    @property
    def there(self) -> bool:
        """Whether gateways reach it."""
        return self.up and self.robot.on and self.robot.in_reach

    def end(self) -> None:
        """End the server: it forgets all of its goals, and the robot stands."""
        self.up = False
        self.drop()
        self.robot.drive()

    def drop(self) -> None:
        """Forget all goals."""
        for goal in self.goals.values():
            if goal.runs:
                self._chance.say(self.name, f"drops {goal.goal_id}")
                goal.ended_at = self._chance.loop.time()
            if goal.task is not None:
                goal.task.cancel()
        self.goals = {}

    def start(self) -> None:
        """Start the server again, if it has ended."""
        if not self.up:
            self.up = True
            self.tell()

    def freeze(self, seconds: float) -> None:
        """Answer nothing for some time."""
        self.awake.clear()
        self._chance.later(seconds, self.awake.set)

    # ------------------------------------------------------------------ requests

    def request(self, reader: Reader, call: Call, handle: Callable[[], Any]) -> None:
        """Take a request, which may be lost, as may its answer."""

        async def carry() -> None:
            await asyncio.sleep(self._chance.latency())
            if not self.there:
                return
            await self.awake.wait()
            await asyncio.sleep(self._chance.random.uniform(0, 0.001))
            if not self.there:
                return
            answer = handle()
            if answer is not None and self._chance.random.random() >= self.robot.answers_lost:
                reader.carry(lambda: call.answer(answer))

        self._chance.spawn(carry())

    def take(self, goal_id: str, message: bytes) -> Any:
        """Accept a goal, or reject it. An id is accepted once."""
        stamp = self._chance.loop.time_ns()
        answer = SimpleNamespace(accepted=False, stamp=SimpleNamespace(sec=stamp // 10**9, nanosec=stamp % 10**9))
        busy = any(goal.runs for goal in self.goals.values())
        if goal_id in self.goals or busy or self._chance.random.random() < self.robot.rejects:
            self._chance.say(self.name, f"rejects {goal_id}")
            return answer
        answer.accepted = True
        goal = self.goals[goal_id] = CarriedOut(goal_id, json.loads(message), self._chance.loop.time())
        self._chance.say(self.name, f"accepts {goal_id} {goal.message}")
        self.robot.on_accept(self, goal)
        goal.task = self._chance.loop.create_task(self._run(goal))
        self.tell()
        return answer

    def cancel(self, goal_id: str | None) -> CancelAnswer:
        """Cancel a goal, or all of them."""
        asked = [*self.goals] if goal_id is None else [goal_id]
        taken = set[str]()
        for each in asked:
            goal = self.goals.get(each)
            if goal is None or not goal.runs or goal.status is S.CANCELING:
                continue
            if self._chance.random.random() < self.robot.refuses:
                continue
            taken.add(each)
            goal.status = S.CANCELING
            if goal.task is not None:
                goal.task.cancel()
            goal.task = self._chance.loop.create_task(self._cancel(goal))
        if taken:
            self.tell()
        if taken or goal_id is None:
            return CancelAnswer(frozenset(taken), 0)
        known = self.goals.get(goal_id)
        code = UNKNOWN_GOAL if known is None else REFUSED_GOAL if known.runs else ENDED_GOAL
        if known is not None and known.status is S.CANCELING:
            code = ENDED_GOAL
        return CancelAnswer(frozenset(), code)

    def await_result(self, goal_id: str, answer: Callable[[ResultAnswer], None]) -> None:
        """Answer once a goal has ended."""
        goal = self.goals.get(goal_id)
        if goal is None:
            answer(ResultAnswer(None, None))
        elif goal.runs:
            goal.awaiting.append(answer)
        else:
            answer(ResultAnswer(goal.status, b"{}"))

    # ------------------------------------------------------------------ goals

    async def _run(self, goal: CarriedOut) -> None:
        await asyncio.sleep(self._chance.random.uniform(0.0005, 0.02))
        goal.status = S.EXECUTING
        self.tell()
        takes, ends = self.robot.plan(self, goal)
        if takes is None:
            await asyncio.Event().wait()
            return
        await asyncio.sleep(takes)
        await self.awake.wait()
        self._end(goal, self.robot.finish(self, goal) if ends else S.ABORTED)

    def unhang(self, goal: CarriedOut) -> None:
        """Let a goal end that would never end by itself."""
        goal.hangs = False

        def end() -> None:
            if goal.runs:
                self._end(goal, S.SUCCEEDED)

        self._chance.later(1.0, end)

    async def _cancel(self, goal: CarriedOut) -> None:
        await asyncio.sleep(self._chance.random.uniform(0.001, 3.0))
        await self.awake.wait()
        self._end(goal, S.CANCELED)

    def _end(self, goal: CarriedOut, status: GoalStatus) -> None:
        if not goal.runs:
            return
        goal.status, goal.ended_at = status, self._chance.loop.time()
        self.robot.drive()
        self._chance.say(self.name, f"{goal.goal_id} {status.value}")
        for answer in goal.awaiting:
            answer(ResultAnswer(status, b"{}"))
        goal.awaiting = []
        over = [each for each, known in self.goals.items() if not known.runs]
        for each in over[:-REMEMBERED]:
            del self.goals[each]
        self.tell()

    def tell(self) -> None:
        """Tell all gateways the states of the goals."""
        for reader in self.readers:
            self.tell_to(reader)

    def tell_to(self, reader: Reader) -> None:
        """Tell one gateway the states of the goals."""
        if not self.there:
            return
        stamp = self._chance.loop.time_ns()
        reports = [StatusReport(goal.goal_id, goal.status, round(goal.at * 1e9)) for goal in self.goals.values()]
        reader.carry(lambda: reader.on_status(reports, stamp))
