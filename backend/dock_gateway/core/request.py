"""The request that is being handled: known to everything that runs for it."""

import asyncio
from collections.abc import Callable, Coroutine, Hashable, Mapping
from contextlib import AbstractAsyncContextManager, AbstractContextManager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, NamedTuple

from dock_gateway.core.event import utc_now


class RequestContext(NamedTuple):
    """A request's id, and the W3C headers of the trace that it is part of, if there is one."""

    request_id: str
    trace: Mapping[str, str]


Watch = Callable[[Callable[[], object]], AbstractContextManager[None]]


@dataclass
class Permit:
    """The authorization of a request or a command: its login was valid and sufficed when it was checked.

    Attributes:
        require: Raises an error if that is no longer true.
        watch: Calls a function as soon as it is no longer true, while a block runs.
        slot: Takes a place of the user while a block runs (`Quotas.slot`).
        turn: Waits for the user's turn (`Quotas.turn`).
        acted_at: When the request acted last.
        action: Absolute name of the action that it has picked or was given; None: not known yet.
    """

    require: Callable[[], None]
    watch: Watch
    slot: Callable[[str, Hashable, str], AbstractContextManager[None]]
    turn: Callable[[str], AbstractAsyncContextManager[None]]
    acted_at: datetime = field(default_factory=utc_now)
    action: str | None = None


# A task that is started while a request is handled inherits both.
CURRENT: ContextVar[RequestContext | None] = ContextVar("request", default=None)
PERMIT: ContextVar[Permit | None] = ContextVar("permit", default=None)


def act() -> None:
    """Check the login of the request again, at the moment at which it acts: what it waited for may have taken seconds.

    Called right before a goal is sent, for example, with nothing awaited in between. A stop never asks.

    Raises:
        NotAuthenticated: The login has ended, or what it allows has changed (`invalid_token`).
    """
    permit = PERMIT.get()
    if permit is not None:
        permit.require()
        permit.acted_at = utc_now()


def acts_on(action: str) -> None:
    """Note the action that the request sends a goal to: the audit log has it even if the goal is refused.

    Args:
        action: Its absolute name.
    """
    if (permit := PERMIT.get()) is not None:
        permit.action = action


def slot(what: str, key: Hashable = None, per: str = "") -> AbstractContextManager[None]:
    """Take a place of the request's user while a block runs. What the gateway does by itself needs none.

    Args:
        what: What is shared, as `http.quotas.limits` names it.
        key: What the place is for, if others may share it.
        per: What the limit is for, such as a service, where each of them has its own.

    Raises:
        TooManyRequests: The user has their share already, or all places are in use.
    """
    permit = PERMIT.get()
    return nullcontext() if permit is None else permit.slot(what, key, per)


def turn(what: str) -> AbstractAsyncContextManager[None]:
    """Wait for the turn of the request's user: what they ask for at the same time does not keep others waiting.

    Args:
        what: What takes long, such as `large reads`.
    """
    permit = PERMIT.get()
    return nullcontext() if permit is None else permit.turn(what)


async def wait_while_permitted(waiting: Coroutine[Any, Any, None]) -> None:
    """Wait for something that a request only watches, as long as its login lasts.

    Raises:
        NotAuthenticated: The login has ended, or what it allows has changed (`invalid_token`).
    """
    permit = PERMIT.get()
    if permit is None:
        await waiting
        return
    task = asyncio.create_task(waiting)
    try:
        with permit.watch(task.cancel):
            await asyncio.wait({task})
    finally:
        task.cancel()
    permit.require()
