"""The action server: it runs goals, and knows nothing of the gateways' troubles."""

import asyncio
from collections import defaultdict
from collections.abc import Callable
from typing import Protocol

from dock_gateway.core.goal import GoalStatus, ResultAnswer
from dock_gateway.ros.status import StatusReport
from tests.dock_gateway.simulation.chance import Chance


class Listener(Protocol):
    """A gateway, as the action server knows it."""

    def carry(self, link: str, message: Callable[[], object]) -> None:
        """Bring a message there; those of one link arrive in their order."""

    def on_status(self, action: str, reports: list[StatusReport], stamp: int) -> None:
        """Take the states of all goals."""

    def on_feedback(self, action: str, goal_id: str, feedback: bytes, stamp: int) -> None:
        """Take the feedback of a goal."""


class ActionServer:
    """Runs goals, and tells every gateway that has discovered it."""

    def __init__(self, chance: Chance) -> None:
        self._chance = chance
        self.goals: dict[str, tuple[str, GoalStatus, int]] = {}
        self._ended: dict[str, ResultAnswer] = {}
        self._awaiting: defaultdict[str, list[Callable[[ResultAnswer], None]]] = defaultdict(list)
        self._readers: defaultdict[tuple[str, str], list[Listener]] = defaultdict(list)

    @property
    def idle(self) -> bool:
        """Whether all goals have ended."""
        return self._ended.keys() == self.goals.keys()

    def listen(self, gateway: Listener, action: str, topic: str) -> None:
        """A gateway has discovered a topic. The last status message is kept for it."""
        self._readers[action, topic].append(gateway)
        if topic == "status":
            self._tell_status(action, [gateway])

    def take(self, goal_id: str, action: str) -> int:
        """Accept a goal and run it; return when it was accepted."""
        stamp = self._chance.loop.time_ns()
        self._set(goal_id, action, GoalStatus.ACCEPTED, stamp)
        self._chance.later(0.0005, lambda: self._chance.spawn(self._run(goal_id, action)))
        return stamp

    async def _run(self, goal_id: str, action: str) -> None:
        draw = self._chance.random
        stamp = self.goals[goal_id][2]
        self._set(goal_id, action, GoalStatus.EXECUTING, stamp)
        for number in range(draw.randint(0, 4)):
            await asyncio.sleep(draw.uniform(0.001, 0.06))
            self._tell_feedback(goal_id, action, number)
        self._ended[goal_id] = ResultAnswer(GoalStatus.SUCCEEDED, b'{"of":"%s"}' % goal_id.encode())
        self._set(goal_id, action, GoalStatus.SUCCEEDED, stamp)
        self._chance.say("server", f"{goal_id} ended")
        for answer in self._awaiting.pop(goal_id, []):
            answer(self._ended[goal_id])

    def await_end(self, goal_id: str, answer: Callable[[ResultAnswer], None]) -> None:
        if goal_id in self._ended:
            answer(self._ended[goal_id])
        elif goal_id in self.goals:
            self._awaiting[goal_id].append(answer)

    def _set(self, goal_id: str, action: str, status: GoalStatus, accepted: int) -> None:
        self.goals[goal_id] = (action, status, accepted)
        self._tell_status(action, self._readers[action, "status"])

    def _tell_status(self, action: str, gateways: list[Listener]) -> None:
        stamp = self._chance.loop.time_ns()
        reports = [StatusReport(g, status, at) for g, (of, status, at) in self.goals.items() if of == action]
        for gateway in gateways:
            gateway.carry(f"status {action}", lambda to=gateway: to.on_status(action, reports, stamp))

    def _tell_feedback(self, goal_id: str, action: str, number: int) -> None:
        stamp, feedback = self._chance.loop.time_ns(), b'{"n":%d}' % number
        for gateway in self._readers[action, "feedback"]:
            gateway.carry(f"feedback {action}", lambda to=gateway: to.on_feedback(action, goal_id, feedback, stamp))
