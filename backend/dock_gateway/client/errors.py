"""The errors of a client. The text of each is a sentence for people."""

from typing import Any

from dock_gateway.client.documents import Goal
from dock_gateway.core.goal import GoalStatus


class ClientError(Exception):
    """A request or a stream failed."""


class GatewayUnreachable(ClientError):
    """There is no gateway, or the connection was lost and not again possible within the client's patience."""


class ClientTimeout(ClientError, TimeoutError):
    """An answer, or the end of a goal, did not come in the time that the caller gave.

    The gateway may have carried out what it was asked for, and may be doing so still.
    """


class GatewayRefused(ClientError):
    """The gateway refused a request.

    Attributes:
        status: The HTTP status.
        code: A stable code, such as `dock_busy`; see docs/errors.md.
        detail: The reason.
        problem: The whole answer (RFC 9457), with members such as `errors`.
    """

    def __init__(self, status: int, problem: Any = None) -> None:
        self.status = status
        self.problem: dict[str, Any] = problem if isinstance(problem, dict) else {}
        self.code: str = self.problem.get("code", str(status))
        self.detail: str = self.problem.get("detail", "the answer does not come from a dock-gateway")
        super().__init__(f"{self.code}: {self.detail}")


class GoalFailed(ClientError):
    """A goal ended, but did not succeed. `state` says how, `state.error` why."""

    def __init__(self, state: Goal) -> None:
        self.state = state
        reason = f": {state.error.detail}" if state.error else ""
        super().__init__(f"goal {state.goal_id} {state.status}{reason}")


def succeeded(state: Goal) -> Goal:
    """Return the state of a goal that has ended.

    Raises:
        GoalFailed: It did not succeed.
    """
    if state.status is not GoalStatus.SUCCEEDED:
        raise GoalFailed(state)
    return state
