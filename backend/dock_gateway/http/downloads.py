"""Downloads: a file that is sent as a stream, as CSV or JSON."""

from collections.abc import AsyncGenerator
from contextlib import aclosing
from typing import Annotated, Literal

from fastapi import Query, Request
from starlette.responses import Response

from dock_gateway.core.request import PERMIT
from dock_gateway.http.parts import parts_of
from dock_gateway.http.principal import principal_of
from dock_gateway.http.quotas import Quotas
from dock_gateway.http.slow_clients import PacedResponse
from dock_gateway.settings import Settings

Format = Literal["csv", "json"]
FormatQuery = Annotated[Format, Query(description="`csv` for spreadsheets, `json` for programs")]
MEDIA_TYPES = {"csv": "text/csv; charset=utf-8", "json": "application/json"}
CSV = {"text/csv": {"schema": {"type": "string"}}}


async def download(request: Request, chunks: AsyncGenerator[bytes], name: str, kind: Format) -> Response:
    """Return a file as a stream, which ends with the login.

    An error before the first piece becomes an error response.
    """
    parts, principal, permit = parts_of(request), principal_of(request), PERMIT.get()

    async def counted() -> AsyncGenerator[bytes]:
        async with aclosing(chunks):
            with parts[Quotas].slot(principal, "exports"):
                async for chunk in chunks:
                    if permit is not None:
                        permit.require()
                    yield chunk

    held = counted()
    first = await anext(held)
    headers = {"Content-Disposition": f'attachment; filename="{name}.{kind}"'}
    timeout = parts[Settings].subscriber_timeout
    return PacedResponse(first, held, timeout, media_type=MEDIA_TYPES[kind], headers=headers)
