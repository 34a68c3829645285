"""The command line as a client: a Ctrl-C always cancels, and no proxy stands between it and this machine."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import httpx2
import orjson
import pytest
from click.testing import CliRunner

from dock_gateway.cli import client, main

GOAL = {"goal_id": "7d9c1c9e-0000-4000-8000-000000000000", "status": "canceled", "origin": "gateway"}
EVENTS = [{"type": "snapshot", "goals": [GOAL]}]


class Gateway:
    """In place of the network: keeps what is sent, and can let the user press Ctrl-C while it is."""

    def __init__(self) -> None:
        self.requests: list[tuple[str, str, dict[str, Any]]] = []
        self.connections: list[dict[str, Any]] = []
        self.interrupted: Callable[[int], bool] = lambda number: False

    def request(self, method: str, url: str, **options: Any) -> httpx2.Response:
        self.requests.append((method, url.partition("//")[2].partition("/")[2], options))
        if self.interrupted(len(self.requests)):
            raise KeyboardInterrupt
        return httpx2.Response(200, content=orjson.dumps(GOAL))

    @contextmanager
    def connect(self, _: str, **options: Any) -> Iterator[Iterator[bytes]]:
        self.connections.append(options)
        yield map(orjson.dumps, EVENTS)


@pytest.fixture
def gateway(monkeypatch: pytest.MonkeyPatch) -> Gateway:
    gateway = Gateway()
    monkeypatch.setattr(client.httpx2, "request", gateway.request)
    monkeypatch.setattr(client, "connect", gateway.connect)
    monkeypatch.delenv("DOCK_GATEWAY_URL", raising=False)
    return gateway


@pytest.mark.parametrize("options", [[], ["--no-wait"], ["--json"]])
def test_ctrl_c_while_the_goal_is_sent_cancels_it(gateway: Gateway, options: list[str]) -> None:
    gateway.interrupted = lambda number: number == 1
    result = CliRunner().invoke(main, ["dock", *options])
    assert result.exit_code == 1
    assert "canceling" in result.output
    assert [(method, path) for method, path, _ in gateway.requests] == [
        ("POST", "dock"),
        ("POST", "dock"),
        ("POST", f"dock/{GOAL['goal_id']}/cancel"),
        ("GET", f"dock/{GOAL['goal_id']}"),
    ]
    first, second = (options for _, _, options in gateway.requests[:2])
    assert first["content"] == second["content"]
    assert first["headers"]["Idempotency-Key"] == second["headers"]["Idempotency-Key"]


def test_each_goal_has_a_key_of_its_own(gateway: Gateway) -> None:
    for _ in range(2):
        CliRunner().invoke(main, ["dock", "--no-wait"])
    first, second = (options["headers"]["Idempotency-Key"] for _, _, options in gateway.requests)
    assert first != second


@pytest.mark.parametrize(
    ("url", "direct"),
    [
        ("http://127.0.0.1:8000", True),
        ("http://localhost:8000", True),
        ("http://[::1]:8000", True),
        ("https://robot.example", False),
        ("http://localhost.example", False),
    ],
)
def test_no_proxy_stands_before_this_machine(gateway: Gateway, url: str, direct: bool) -> None:
    CliRunner().invoke(main, ["dock", "--url", url])
    assert {options["trust_env"] for _, _, options in gateway.requests} == {not direct}
    assert [options["proxy"] for options in gateway.connections] == [None if direct else True]
