"""`/mcp` as tests of every door use it: plain requests, as an agent without the official client may send them."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import httpx2
import orjson

from tests.support.doors import Door, Stop
from tests.support.gateway import RunningGateway
from tests.support.waiting import PATIENCE

HEADERS = {"Accept": "application/json, text/event-stream", "Content-Type": "application/json"}


def http_of(gateway: RunningGateway) -> httpx2.Client:
    return httpx2.Client(base_url=gateway.url, headers=HEADERS, timeout=PATIENCE)


def stop_call(arguments: Any, identity: Any = 1) -> bytes:
    """A call of the tool that stops."""
    params = {"name": "stop_robots", "arguments": arguments}
    return orjson.dumps({"jsonrpc": "2.0", "id": identity, "method": "tools/call", "params": params})


@contextmanager
def _stops(gateway: RunningGateway) -> Iterator[Stop]:
    with http_of(gateway) as http:

        def stop(fields: Any) -> dict[str, Any]:
            answer = http.post("/mcp", content=stop_call(fields))
            assert answer.status_code == 200, answer.text
            data = next(line for line in answer.text.splitlines() if "jsonrpc" in line)
            result = orjson.loads(data.removeprefix("data: "))["result"]
            assert not result.get("isError"), result
            report: dict[str, Any] = result["structuredContent"]
            return report

        yield stop


SETTINGS = {"mcp": "true"}
DOORS = (Door("agents", _stops, settings=SETTINGS),)
