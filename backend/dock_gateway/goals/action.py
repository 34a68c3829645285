"""One action: its goals, the operations on them, and its server's state."""

import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import BatteryState

from dock_gateway.core.dock_adapters.adapter import DESIRED, POSE, DockAdapter
from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.event import loss_event, system_event, utc_now
from dock_gateway.core.tasks import Tasks
from dock_gateway.goals.action_context import ActionContext
from dock_gateway.goals.action_document import action_document
from dock_gateway.goals.cancellation import Canceler
from dock_gateway.goals.delivery import GoalDelivery
from dock_gateway.goals.liveness import ServerState, ServerWatch
from dock_gateway.goals.rejoining import Rejoiner
from dock_gateway.goals.submitter import Submitter
from dock_gateway.goals.tracker import GoalTracker
from dock_gateway.ros.action_port import ActionPort
from dock_gateway.ros.listener import Unread
from dock_gateway.ros.messages.codec import codec

# Seconds after which an action that is off the graph is removed. A restart takes less.
FORGET_AFTER = 10.0


class Action:
    """One action: its goals, the operations on them, and its server's state.

    Args:
        port: Its part of ROS.
        context: The parts of the gateway that it uses.
        adapter: How the gateway speaks to it, if it docks or undocks robots.
        remark: Returns what is wrong around its robot: added to the reason of goals that are aborted.
        default_dock: The dock that a goal means if it names none; empty: none.
        pinned: Whether to keep it even without a server.
        ping_idle: Whether to ask its server for a sign of life while no goal runs.

    Attributes:
        tracker: All goals on the action, regardless of their sender.
        submitter: Submits goals.
        delivery: The goals that are on their way to the action server.
        canceler: Cancels goals.
        watch: Monitors the action server.
        feedback_dropped: Number of feedback messages not read since the gateway started.
        last_seen: When it last had a server, on the monotonic clock.
    """

    def __init__(
        self,
        port: ActionPort,
        context: ActionContext,
        *,
        adapter: DockAdapter | None = None,
        remark: Callable[[], str] = str,
        default_dock: str = "",
        pinned: bool = False,
        ping_idle: bool = False,
    ) -> None:
        settings, fanout, history, limits = context.settings, context.fanout, context.history, context.limits
        self.port = port
        self.name = port.action_name
        self.type = port.action_type
        self.adapter = adapter
        self.verb = None if adapter is None else adapter.verb
        self.pinned = pinned
        self.last_seen = float("-inf") if pinned else time.monotonic()
        self.feedback_dropped = 0
        self._fanout = fanout
        self.default_dock = default_dock
        self.tracker = GoalTracker(
            port,
            fanout,
            history,
            context.reasons,
            adapter,
            remark=remark,
            before_lost=context.before_lost,
            limits=limits,
        )
        self.watch = ServerWatch(self.tracker, settings, self._publish_server, ping_idle=ping_idle, limits=limits)
        self.canceler = Canceler(settings, self.tracker, context.interlock, limits)
        self.delivery = GoalDelivery(context, self.tracker, self.watch, self.canceler)
        self.submitter = Submitter(settings, history, self.tracker, self.delivery, adapter)
        self._tasks = Tasks(f"monitoring {self.name}")
        self._tasks.spawn(self.watch.run())
        self._tasks.spawn(Rejoiner(self.tracker, self.watch, limits).run())

    @property
    def on_graph(self) -> bool:
        """Whether it has a server, or had one a moment ago."""
        return self.unseen_for < FORGET_AFTER

    @property
    def unseen_for(self) -> float:
        """Seconds since it last had a server."""
        return time.monotonic() - self.last_seen

    @property
    def unknown_goals_ignored(self) -> int:
        """Number of goals in status messages, and of feedback messages, that named too many unknown goals."""
        return 0 if self.port.listener is None else self.port.listener.admission.ignored

    @property
    def hint(self) -> str | None:
        """The fault of its messages, without a full stop; None if there is none."""
        return None if self.port.listener is None else self.port.listener.excess

    @property
    def family(self) -> str:
        """The family of a docking action: who defines its type; empty for all others."""
        return "" if self.adapter is None else self.adapter.family

    @property
    def busy(self) -> bool:
        """Whether a goal is running on it."""
        return bool(self.tracker.running())

    def document(self) -> dict[str, Any]:
        """Return the action as JSON."""
        return action_document(
            self.watch.state,
            self.verb,
            self.hint,
            running_goals=len(self.tracker.running()),
            feedback_dropped=self.feedback_dropped,
            unknown_goals_ignored=self.unknown_goals_ignored,
        )

    async def read_goal(self, request: object, path: str = "") -> Any:
        """Return the goal message for a request. Others have their turn while a large one is read.

        Args:
            request: Decoded JSON, or the message; None: the client gave none.
            path: Where it was, for errors.

        Raises:
            InvalidField: It is not valid, or is missing.
            Conflict: `stopped`: a stop was requested in the meantime.
        """
        # To use a message's defaults, a client has to send `{}`. All zeros may be a pose to drive to.
        if request is None:
            raise _missing(path)
        stops = self.delivery.stops
        message = await self.port.goal_codec.read(request, path)
        if self.delivery.stops != stops:
            self.delivery.require_no_stop_since(stops)
        return message

    def read_docking_request(self, request: object = None, path: str = "") -> Any:
        """Return the goal message for a request: for docking and undocking a simple request, or the message's fields.

        Args:
            request: Decoded JSON, or the message; None: the default, which not every action has.
            path: Where it was, for errors.

        Raises:
            InvalidField: It is not valid, is missing, or the action cannot take it.
        """
        if request is None and (request := None if self.adapter is None else self.adapter.default) is None:
            raise _missing(path)
        if self.adapter is None or not isinstance(request, dict):
            return self.port.goal_codec.parse(request, path)
        if DESIRED in request and DESIRED in self.adapter.takes:
            battery = codec(BatteryState)
            state = battery.parse(request[DESIRED], f"{path}.{DESIRED}" if path else DESIRED)
            request = {**request, DESIRED: battery.document(state)}
        if POSE in request and POSE in self.adapter.takes:
            stamped = codec(PoseStamped)
            pose = stamped.parse(request[POSE], f"{path}.{POSE}" if path else POSE)
            request = {**request, POSE: stamped.document(pose)}
        goal = self.adapter.goal(request, self.default_dock, path)
        return self.port.goal_codec.parse(goal, path, self.adapter.takes)

    def _publish_server(self, state: ServerState) -> None:
        self._fanout.publish(system_event("action_server", state, utc_now(), action_name=self.name))

    def on_loss(self, goal_id: str, why: Unread, count: int) -> None:
        """Count feedback that was not read. It still is a sign of life."""
        self.tracker.heard()
        self.feedback_dropped += count
        self._fanout.publish(loss_event(goal_id, self.name, why, count, utc_now()))

    async def close(self) -> None:
        """Stop all background work."""
        await self._tasks.close()
        await self.tracker.close()


def _missing(path: str) -> InvalidField:
    return InvalidField([FieldError(path, "an object, {} for the defaults", "got none")])
