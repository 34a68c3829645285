"""The session of an action client: a state machine of its requests and their timeouts, stepped with the time."""

import enum
from dataclasses import dataclass


class ExitCode(enum.IntEnum):
    """Exit codes of the clients; 2 is a wrong command line."""

    SUCCEEDED = 0
    ABORTED = 1
    REJECTED = 3
    CANCELED = 4
    NO_SERVER = 5
    LOST = 6
    INTERRUPTED = 130


class Request(enum.Enum):
    """The next request to the server."""

    PING = "ping"
    SEND_GOAL = "send_goal"
    CANCEL_GOAL = "cancel_goal"


class Phase(enum.Enum):
    """The phase of the session."""

    SEARCHING = "searching"
    SENT = "sent"
    RUNNING = "running"
    OVER = "over"


STATUS_TO_EXIT = {4: ExitCode.SUCCEEDED, 5: ExitCode.CANCELED, 6: ExitCode.ABORTED}
"""By the terminal states of action_msgs/GoalStatus; any other is that of a server that knows no such goal."""

OUTCOMES = {
    ExitCode.SUCCEEDED: "the goal succeeded",
    ExitCode.CANCELED: "the goal was canceled",
    ExitCode.ABORTED: "the goal was aborted",
}


@dataclass(frozen=True)
class Patience:
    """The time limits of a client, all in seconds.

    Attributes:
        server: For a server that answers.
        acceptance: For the answer to the goal.
        silence: Without a sign of life before the server is pinged.
        lost: Without a sign of life, pings included, before the server is given up.
        cancel: For the end of a goal that was asked to end.
        ping_period: Between two pings.
    """

    server: float = 10.0
    acceptance: float = 5.0
    silence: float = 3.0
    lost: float = 10.0
    cancel: float = 5.0
    ping_period: float = 0.5


class Session:
    """One goal of one client, from the search for a server to an exit code.

    A server's death is not signalled by ROS, so every wait here has a deadline.
    """

    def __init__(self, patience: Patience, now: float) -> None:
        """Start to search.

        Args:
            patience: The deadlines.
            now: Seconds of the monotonic clock, as everywhere here.
        """
        self.phase = Phase.SEARCHING
        self.exit_code: ExitCode | None = None
        self.explanation = ""
        self._patience = patience
        self._since = now
        self._heard_at = now
        self._answered = False
        self._pinged_at: float | None = None
        self._interrupts = 0
        self._cancel_wanted = False
        self._canceled_at: float | None = None

    def step(self, now: float) -> Request | None:
        """Return the request to send now, if any; call it about ten times a second."""
        if self.phase is Phase.SEARCHING:
            return self._search(now)
        if self.phase is Phase.SENT:
            return self._await_acceptance(now)
        if self.phase is Phase.RUNNING:
            return self._await_result(now)
        return None

    def _search(self, now: float) -> Request | None:
        if self._interrupts:
            self._finish(ExitCode.INTERRUPTED, "interrupted before the goal was sent")
            return None
        if self._answered:
            self.phase = Phase.SENT
            self._since = now
            return Request.SEND_GOAL
        if now - self._since >= self._patience.server:
            self._finish(ExitCode.NO_SERVER, f"no action server answered within {self._patience.server:g} s")
            return None
        return self._ping(now)

    def _await_acceptance(self, now: float) -> Request | None:
        if self._interrupts > 1:
            self._finish(ExitCode.INTERRUPTED, "exited before the server answered; the goal is canceled if it runs")
            return Request.CANCEL_GOAL
        if now - self._since < self._patience.acceptance:
            return None
        self._finish(ExitCode.NO_SERVER, f"no answer to the goal within {self._patience.acceptance:g} s")
        return Request.CANCEL_GOAL

    def _await_result(self, now: float) -> Request | None:
        if self._interrupts > 1:
            self._finish(ExitCode.INTERRUPTED, "exited before the goal ended; it may still be running")
        elif self._cancel_wanted and self._canceled_at is None:
            self._canceled_at = now
            return Request.CANCEL_GOAL
        elif self._canceled_at is not None and now - self._canceled_at >= self._patience.cancel:
            self._finish(
                ExitCode.LOST, f"the goal did not end within {self._patience.cancel:g} s after the cancel request"
            )
        elif now - self._heard_at >= self._patience.lost:
            self._finish(ExitCode.LOST, f"no response from the action server for {self._patience.lost:g} s")
        elif now - self._heard_at >= self._patience.silence:
            return self._ping(now)
        return None

    def _ping(self, now: float) -> Request | None:
        if self._pinged_at is not None and now - self._pinged_at < self._patience.ping_period:
            return None
        self._pinged_at = now
        return Request.PING

    def heard(self, now: float) -> None:
        """The server gave a sign of life: feedback, or the answer to a ping."""
        self._answered = True
        self._heard_at = now

    def answered(self, *, accepted: bool, now: float) -> None:
        """The server accepted or rejected the goal."""
        if self.phase is not Phase.SENT:
            return
        self.heard(now)
        if accepted:
            self.phase = Phase.RUNNING
        else:
            self._finish(ExitCode.REJECTED, "the goal was rejected")

    def ended(self, status: int) -> None:
        """The result came.

        Args:
            status: One of action_msgs/GoalStatus.
        """
        if self.phase is not Phase.RUNNING:
            return
        exit_code = STATUS_TO_EXIT.get(status)
        if exit_code is None:
            self._finish(ExitCode.LOST, "the action server no longer knows the goal; it was restarted")
        elif exit_code is ExitCode.CANCELED and self._interrupts:
            self._finish(ExitCode.INTERRUPTED, "the goal was canceled")
        else:
            self._finish(exit_code, OUTCOMES[exit_code])

    def interrupt(self) -> None:
        """The user pressed Ctrl-C: the first time the goal is canceled, the second time it is left alone."""
        self._interrupts += 1
        self._cancel_wanted = True

    def cancel_refused(self) -> None:
        """The server does not cancel the goal: it goes on, until its end or the second Ctrl-C."""
        self._cancel_wanted = False
        self._canceled_at = None

    def _finish(self, exit_code: ExitCode, explanation: str) -> None:
        self.phase = Phase.OVER
        self.exit_code = exit_code
        self.explanation = explanation
