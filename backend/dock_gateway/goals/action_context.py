"""The parts of the gateway that every action uses."""

from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass

from dock_gateway.core.access import Principal
from dock_gateway.core.dock_adapters.adapter import Fields
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalError, Json
from dock_gateway.core.tasks import PendingFacts
from dock_gateway.goals.limits import LIMITS, GoalLimits
from dock_gateway.goals.tracker import BeforeLost
from dock_gateway.latch.interlock import Interlock
from dock_gateway.settings import Settings
from dock_gateway.storage import History

# Waits until a goal may be sent, or raises why it may not: given who sends it, its action and its message.
BeforeSend = Callable[[Principal, str, Json], Awaitable[None]]
# Waits until a goal may be stored and sent, whoever sends it (None: the gateway itself). Returns other fields for its
# message, or None, or raises why it may not be sent.
Gate = Callable[[Principal | None, Goal], Awaitable[Fields | None]]


@dataclass(frozen=True)
class ActionContext:
    """The parts of the gateway that every action uses.

    Attributes:
        settings: Names and deadlines.
        fanout: Receives events.
        history: Stores goals.
        reasons: Why goals were rejected or aborted.
        interlock: The latched stops.
        limits: How long to wait for what is not yet known of goals.
        before_send: Called and awaited before each goal is sent; what it raises refuses the goal.
        gates: Called and awaited after that, with the goal itself, also if the gateway sends it.
        before_lost: Called with a goal that is about to be lost.
    """

    settings: Settings
    fanout: Fanout
    history: History
    reasons: PendingFacts[GoalError]
    interlock: Interlock
    limits: GoalLimits = LIMITS
    before_send: Iterable[BeforeSend] = ()
    before_lost: Iterable[BeforeLost] = ()
    gates: Iterable[Gate] = ()
