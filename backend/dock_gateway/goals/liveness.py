"""Checks whether the action server is present and answers. DDS does not signal a peer's death, so this polls.

Silence alone is no proof of death: a server that blocks its only executor thread does not answer, and a killed one
stays on the graph for a while. Absence from the graph is no proof either: after an outage, messages from a server may
arrive long before discovery finds it. So a silent goal is `stalled` first. It is `lost` after a timeout, or when the
server has left the graph and is silent.
"""

import asyncio
import logging
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from dock_gateway.core.errors import Conflict, GatewayError, Unavailable
from dock_gateway.core.goal import GoalError, GoalStatus
from dock_gateway.goals.duplicates import Duplicates
from dock_gateway.goals.goal_machine import GoalMachine
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.settings import Settings
from robot_io.ros_variables import DISCOVERY_SERVER_HINT, sees_part_of_graph

log = logging.getLogger(__name__)

PING_TIMEOUT = 1.0
# Seconds without news after which a goal's result is requested again, then after twice as many, and so on.
FIRST_PROBE = 5.0


@dataclass(frozen=True)
class ServerState:
    """`available`: on the ROS graph. `answering`: it answered recently. `duplicate`: there is more than one."""

    action_name: str
    action_type: str
    available: bool
    answering: bool
    duplicate: bool = False


class ServerWatch:
    """Monitors one action server.

    Args:
        tracker: The goals on that action.
        settings: Deadlines.
        on_change: Called when the server's state has changed.
        ping_idle: Whether a server without goals is pinged, too. If not, it counts as answering while it is on the
            graph.
        limits: How long a server may be off the graph, and how soon one that does not answer is checked again.
    """

    def __init__(
        self,
        tracker: GoalTracker,
        settings: Settings,
        on_change: Callable[[ServerState], None],
        *,
        ping_idle: bool = True,
        limits: GoalLimits = LIMITS,
    ) -> None:
        self._gone_grace = limits.gone_grace
        self._recheck = limits.recheck
        self._ping_idle = ping_idle
        self._tracker = tracker
        self._settings = settings
        self._on_change = on_change
        self._gone_since: float | None = None
        self._told_of_half = False
        self._duplicates = Duplicates()
        self._next_probe: dict[str, float] = {}
        self.state = ServerState(tracker.port.action_name, tracker.port.action_type, available=False, answering=False)

    async def run(self) -> None:
        """Check the server periodically, until canceled."""
        while True:
            try:
                await self.check(ping=self._ping_idle or bool(self._tracker.live))
            except GatewayError as error:
                log.warning("cannot monitor the action server: %s", error.detail)
                self._set(available=False, answering=False, duplicate=self.state.duplicate)
                self._judge()
            interval = self._settings.ping_interval
            await asyncio.sleep(interval if self.state.answering else min(interval, self._recheck))

    async def check(self, *, ping: bool = True) -> ServerState:
        """Check the server once."""
        presence = await self._tracker.port.presence()
        available, answering, crowded = presence.available, False, len(presence.servers) > 1
        if available:
            answering = not ping or time.monotonic() - self._tracker.last_heard < self._settings.ping_interval
            if (crowded or not answering) and await self._ping():
                answering = True
                self._tracker.heard()
        self._note_presence(present=available)
        came_back = answering and not self.state.answering
        duplicate = self._duplicates.found(presence, time.monotonic())
        self._set(available=available, answering=answering, duplicate=duplicate)
        self._judge()
        if came_back:
            self.reconcile()
        self._probe_quiet_goals()
        return self.state

    def _note_presence(self, *, present: bool) -> None:
        if present:
            self._gone_since = None
            self._told_of_half = False
        elif self._gone_since is None:
            self._gone_since = time.monotonic()
        elif self._tracker.last_heard > self._gone_since and not self._told_of_half:
            self._told_of_half = True
            log.warning("%s: messages arrive, but requests do not reach the action server", self.state.action_name)

    async def _ping(self) -> bool:
        try:
            return await self._tracker.port.ping(PING_TIMEOUT)
        except Unavailable:
            return False

    @property
    def ready(self) -> bool:
        """Whether a goal sent now would reach the server, by what is known."""
        return self.state.available and self.state.answering and not self._refuses

    async def require(self) -> None:
        """Check that a goal sent now would reach the server.

        Raises:
            Conflict: `duplicate_action_server`: there is more than one.
            Unavailable: No action server appeared in time (`action_server_unavailable`), or it is there and does not
                answer (`action_server_unresponsive`).
        """
        if self.ready:
            return
        deadline = time.monotonic() + self._settings.server_wait
        while not (await self._tracker.port.presence()).available:
            if time.monotonic() >= deadline:
                partly = f". {DISCOVERY_SERVER_HINT}" if sees_part_of_graph(os.environ) else ""
                raise Unavailable(
                    f"no action server for {self.state.action_name}: check that it runs in this ROS domain{partly}"
                )
            await asyncio.sleep(0.05)
        state = await self.check()
        if self._refuses:
            detail = f"more than one action server serves {state.action_name}, and each would move the robot"
            raise Conflict(f"{detail}: shut down all but one", code="duplicate_action_server")
        if not state.answering:
            detail = f"the action server of {self.state.action_name} does not answer: it may be busy, frozen or dead"
            raise Unavailable(f"{detail}; nothing was sent", code="action_server_unresponsive")

    @property
    def _refuses(self) -> bool:
        return self.state.duplicate and not self._settings.allow_duplicate_servers

    def _set(self, *, available: bool, answering: bool, duplicate: bool) -> None:
        state = replace(self.state, available=available, answering=answering, duplicate=duplicate)
        if state != self.state:
            log.info("action server %s: available %s, answering %s", state.action_name, available, answering)
            self.state = state
            self._on_change(state)

    def _judge(self) -> None:
        now = time.monotonic()
        silence = now - self._tracker.last_heard
        left = self._gone_since is not None and min(now - self._gone_since, silence) > self._gone_grace
        for goal in self._tracker.running():
            if goal.status is GoalStatus.PENDING and goal.goal_id not in self._tracker.taken_up:
                continue  # its sender waits with its own deadline
            if left:
                detail = "the action server left the ROS graph"
                self._tracker.lose(goal, GoalError("action_server_lost", detail))
            elif silence > self._settings.lost_after:
                detail = f"the action server has been silent for {silence:.0f} s and does not answer"
                self._tracker.lose(goal, GoalError("action_server_lost", detail))
            else:
                self._tracker.apply(GoalMachine.stall, goal, stalled=silence > self._settings.stalled_after)

    def reconcile(self) -> None:
        """Ask a server that is back whether it still knows its goals."""
        for goal in list(self._tracker.live.values()):
            if goal.status is not GoalStatus.PENDING or goal.goal_id in self._tracker.taken_up:
                self._tracker.ask_again(goal)

    def _probe_quiet_goals(self) -> None:
        """Request the results of silent goals again: the server may have restarted too fast to be noticed."""
        quiet = {goal.goal_id: goal for goal in self._tracker.running() if goal.status is not GoalStatus.PENDING}
        self._next_probe = {goal_id: due for goal_id, due in self._next_probe.items() if goal_id in quiet}
        for goal_id, goal in quiet.items():
            silence = self._tracker.silence_of(goal)
            due = self._next_probe.setdefault(goal_id, FIRST_PROBE)
            if silence < FIRST_PROBE:
                self._next_probe[goal_id] = FIRST_PROBE
            elif silence >= due and self.state.answering:
                self._next_probe[goal_id] = due * 2
                self._tracker.ask_again(goal)
