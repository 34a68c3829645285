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


@pytest.mark.parametrize("verb", ["dock", "undock"])
@pytest.mark.parametrize("options", [[], ["--no-wait"], ["--json"]])
def test_ctrl_c_while_the_goal_is_sent_cancels_it(gateway: Gateway, verb: str, options: list[str]) -> None:
    gateway.interrupted = lambda number: number == 1
    result = CliRunner().invoke(main, [verb, *options])
    assert result.exit_code == 1
    assert "canceling" in result.output
    assert [(method, path) for method, path, _ in gateway.requests] == [
        ("POST", verb),
        ("POST", verb),
        ("POST", f"{verb}/{GOAL['goal_id']}/cancel"),
        ("GET", f"goals/{GOAL['goal_id']}"),
    ]
    first, second = (options for _, _, options in gateway.requests[:2])
    assert first["content"] == second["content"]
    assert first["headers"]["Idempotency-Key"] == second["headers"]["Idempotency-Key"]


@pytest.mark.parametrize(
    ("arguments", "method", "path", "body"),
    [
        (["stop"], "POST", "stop", {"latch": True, "by": None}),
        (["stop", "--no-latch", "--by", "Ada"], "POST", "stop", {"latch": False, "by": "Ada"}),
        (["stop", "--robot", "/a", "--robot", "/b"], "POST", "stop?robot=%2Fa&robot=%2Fb", {"latch": True, "by": None}),
        (["stop", "--robot", "/fleet/robot1"], "POST", "stop?robot=%2Ffleet%2Frobot1", {"latch": True, "by": None}),
        (["release", "--robot", "/robot1"], "DELETE", "stop?robot=%2Frobot1", None),
    ],
)
def test_stop_and_release(
    gateway: Gateway, arguments: list[str], method: str, path: str, body: dict[str, Any] | None
) -> None:
    CliRunner().invoke(main, arguments)
    ((sent, where, options),) = gateway.requests
    assert (sent, where) == (method, path)
    assert (None if options["content"] is None else orjson.loads(options["content"])) == body


@pytest.mark.parametrize(
    ("status", "stage", "error", "line"),
    [
        ("executing", "NAV_TO_STAGING_POSE", None, "7d9c1c9e executing, nav to staging pose"),
        ("executing", None, None, "7d9c1c9e executing"),
        ("aborted", "RETRY", {"code": "blocked", "detail": "it does not move"}, "7d9c1c9e aborted: it does not move"),
        ("aborted", None, {"code": "blocked", "detail": "a\n\x1b[2Kb\u202e"}, r"7d9c1c9e aborted: a\n\x1b[2Kb\u202e"),
    ],
)
def test_what_is_shown_of_a_status(
    capsys: pytest.CaptureFixture[str], status: str, stage: str | None, error: dict[str, str] | None, line: str
) -> None:
    event = {"type": "status", "goal_id": GOAL["goal_id"], "status": status, "stage": stage, "error": error}
    client.show(event, as_json=False)
    assert capsys.readouterr().out == f"{line}\n"


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


@pytest.mark.parametrize("url", ["localhost:8000", "http://[::1", "http://localhost:99999"])
def test_what_is_no_address_is_said_in_a_sentence(url: str) -> None:
    result = CliRunner().invoke(main, ["watch", "--url", url])
    assert (result.exit_code, result.output.partition(": ")[0]) == (1, "Error")
    assert f"{url} is not the address of a gateway" in result.output
