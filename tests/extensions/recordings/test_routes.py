"""A file that was made for one user counts as one of their exports for as long as it is being sent."""

import contextlib
import os
from pathlib import Path
from typing import Any

import pytest

from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.recordings.routes import PIECE, PartResponse, RecordingResponse
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings

ADA = Principal("ada", PrincipalKind.TOKEN, Grant(Role.VIEWER, robots=("/robot1",)), "ada")
DATA = b"recorded" * PIECE
SCOPE = {"type": "http", "method": "GET", "headers": [], "principal": ADA, "asgi": {"spec_version": "2.4"}}


@pytest.mark.parametrize("leaves", [False, True])
async def test_it_counts_until_it_is_sent_or_the_client_leaves(leaves: bool) -> None:
    quotas = Quotas(Settings(max_exports_per_user=1))

    def response() -> PartResponse:
        return PartResponse(ADA, 10.0, quotas, memoryview(DATA), "part.mcap")

    sent: list[bytes] = []

    async def receive() -> Any:
        raise AssertionError("nothing is read")

    async def send(message: Any) -> None:
        sent.append(message.get("body", b""))
        assert len(sent[-1]) <= PIECE
        with pytest.raises(TooManyRequests, match="exports"):
            await response()(SCOPE, receive, send)
        if leaves and sent[-1]:
            raise OSError("it has left")

    with contextlib.suppress(Exception):
        await response()(SCOPE, receive, send)
    assert b"".join(sent) == (DATA[:PIECE] if leaves else DATA)
    with quotas.slot(ADA, "exports"):
        pass


@pytest.mark.parametrize("method", ["GET", "HEAD"])
async def test_a_file_that_is_cut_off_while_it_is_sent_ends_the_answer(tmp_path: Path, method: str) -> None:
    file = tmp_path / "whole.mcap"
    file.write_bytes(DATA)
    scope = {**SCOPE, "method": method}
    stat = os.stat(file)  # noqa: PTH116
    response = RecordingResponse(ADA, 10.0, Quotas(Settings()), file, stat_result=stat)
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)
        os.truncate(file, 10)

    await response(scope, None, send)  # type: ignore[arg-type]
    assert [each.get("body", b"") for each in sent] == ([b""] if method == "GET" else [b"", b""])
