"""The request that is being handled: known to the log lines and traces of everything that runs for it."""

from collections.abc import Mapping
from contextvars import ContextVar
from typing import NamedTuple


class RequestContext(NamedTuple):
    """A request's id, and the W3C headers of the trace that it is part of, if there is one."""

    request_id: str
    trace: Mapping[str, str]


# A task that is started while a request is handled inherits it.
CURRENT: ContextVar[RequestContext | None] = ContextVar("request", default=None)
