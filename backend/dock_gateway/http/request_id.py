"""Gives every request an id, which its answer and its log lines have."""

import re
import uuid

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.core.request import CURRENT, RequestContext

HEADER = "X-Request-ID"
# Ids of clients that are taken over: harmless wherever a log is read.
ID = re.compile(r"[A-Za-z0-9._-]{1,64}")
# The headers of a trace that the request is part of (W3C Trace Context).
TRACE = ("traceparent", "tracestate")
BEGINS_ANSWER = frozenset({"http.response.start", "websocket.http.response.start", "websocket.accept"})


class RequestId:
    """ASGI middleware that takes the client's `X-Request-ID`, or makes one. The scope has it as `request_id`.

    It is the outermost one, so that the answer to a request that fails with a bug has the id, too.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Pass the request on, and add the id to the answer."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        wanted = headers.get(HEADER, "")
        identity = wanted if ID.fullmatch(wanted) else uuid.uuid4().hex
        scope["request_id"] = identity
        # Not reset afterwards: uvicorn has a task for each request, and logs in it that the application failed.
        CURRENT.set(RequestContext(identity, {name: headers[name] for name in TRACE if name in headers}))

        async def send_with_id(message: Message) -> None:
            if message["type"] in BEGINS_ANSWER:
                message.setdefault("headers", [])
                MutableHeaders(scope=message)[HEADER] = identity
            await send(message)

        await self._app(scope, receive, send_with_id)
