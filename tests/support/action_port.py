"""The port of an action without ROS."""

from collections.abc import Callable
from typing import Any

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import GoalStatus, ResultAnswer
from dock_gateway.ros.action_link import ServerPresence
from dock_gateway.ros.action_port import CancelAnswer
from tests.support.calls import FakeCall


class FakeActionPort:
    """Notes what an action server is asked, and answers as the test says.

    Attributes:
        sent: The requests of goals, by goal id.
        messages: The goals, by goal id.
        results: The requests of results, by goal id.
        canceled: The goal ids of cancel requests; None is all goals.
        cancel_timeouts: Their timeouts in seconds.
        cancel_answers: What they are answered, one after the other; the last one stays. Empty: they are accepted.
        on_cancel: Called before they are answered.
        gone: Why no goal can be sent; None: it can.
        no_results: Why no result can be requested; None: it can.
        on_graph, servers, answered_twice_at: The presence of the server.
        pings: Number of pings.
        answers: Whether they are answered.
    """

    action_name = "/dock"
    action_type = "pkg/action/Dock"

    def __init__(self) -> None:
        self.sent: dict[str, FakeCall] = {}
        self.messages: dict[str, str] = {}
        self.results: dict[str, list[FakeCall]] = {}
        self.canceled: list[str | None] = []
        self.cancel_timeouts: list[float] = []
        self.cancel_answers: list[CancelAnswer | Exception] = []
        self.on_cancel: Callable[[], object] = lambda: None
        self.gone: GatewayError | None = None
        self.no_results: GatewayError | None = None
        self.on_graph = True
        self.servers: set[str] = set()
        self.answered_twice_at = float("-inf")
        self.pings = 0
        self.answers = True

    def encode_goal(self, message: str) -> bytes:
        return message.encode()

    def send(self, goal_id: str, message: str) -> FakeCall:
        if self.gone:
            raise self.gone
        self.messages[goal_id] = message
        self.sent[goal_id] = call = FakeCall()
        return call

    def answer_goal(self, response: Any) -> None:
        """Answer the goal that was sent last."""
        list(self.sent.values())[-1].response.set_result(response)

    def request_result(self, goal_id: str) -> FakeCall:
        if self.no_results:
            raise self.no_results
        self.results.setdefault(goal_id, []).append(call := FakeCall())
        return call

    def answer_result(self, goal_id: str, status: GoalStatus | None, result: bytes | None = None) -> None:
        """Answer the last request of a goal's result."""
        self.results[goal_id][-1].response.set_result(ResultAnswer(status, result))

    async def cancel(self, goal_id: str | None, timeout: float) -> CancelAnswer:
        self.canceled.append(goal_id)
        self.cancel_timeouts.append(timeout)
        self.on_cancel()
        if not self.cancel_answers:
            return CancelAnswer(frozenset({goal_id or ""}), 0)
        answer = self.cancel_answers.pop(0) if len(self.cancel_answers) > 1 else self.cancel_answers[0]
        if isinstance(answer, Exception):
            raise answer
        return answer

    async def presence(self) -> ServerPresence:
        return ServerPresence(self.on_graph, frozenset(self.servers), self.answered_twice_at)

    async def ping(self, timeout: float) -> bool:
        self.pings += 1
        return self.answers
