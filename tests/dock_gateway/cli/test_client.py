"""The command line as a client: a Ctrl-C always cancels."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import httpx2
import orjson
import pytest
from click.testing import CliRunner

from dock_gateway.cli import client, main
from dock_gateway.client import sync
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus, encode

ID = "7d9c1c9e-0000-4000-8000-000000000000"
NOW = utc_now()
GOAL = Goal(ID, "/dock", "pkg/action/Dock", NOW, status=GoalStatus.CANCELED, finished_at=NOW).document()
EVENTS = [{"type": "snapshot", "time": NOW, "goals": [GOAL]}]


class Gateway:
    """In place of the network: keeps what is sent, and can let the user press Ctrl-C while it is."""

    def __init__(self) -> None:
        self.requests: list[tuple[str, str, dict[str, Any]]] = []
        self.interrupted: Callable[[int], bool] = lambda number: False

    def request(self, http: httpx2.Client, method: str, path: str, **options: Any) -> httpx2.Response:
        target = http.build_request(method, path, params=options["params"]).url.raw_path.decode().removeprefix("/")
        self.requests.append((method, target, options))
        if self.interrupted(len(self.requests)):
            raise KeyboardInterrupt
        return httpx2.Response(200, content=encode(GOAL))

    @contextmanager
    def connect(self, _: str, **options: Any) -> Iterator["Gateway"]:
        self.events = map(encode, EVENTS)
        yield self

    def recv(self, _: float | None) -> bytes:
        return next(self.events)


@pytest.fixture
def gateway(monkeypatch: pytest.MonkeyPatch) -> Gateway:
    gateway = Gateway()

    def request(http: httpx2.Client, method: str, path: str, **options: Any) -> httpx2.Response:
        return gateway.request(http, method, path, **options)

    monkeypatch.setattr(httpx2.Client, "request", request)
    monkeypatch.setattr(sync, "connect", gateway.connect)
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
        ("POST", f"goals/{ID}/cancel"),
        ("GET", f"goals/{ID}"),
    ]
    first, second = (options for _, _, options in gateway.requests[:2])
    assert first.get("content") == second.get("content")
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
    assert orjson.loads(options.get("content", "null")) == body


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
    event = {"type": "status", "goal_id": ID, "status": status, "stage": stage, "error": error}
    client.show(event, as_json=False)
    assert capsys.readouterr().out == f"{line}\n"


def test_each_goal_has_a_key_of_its_own(gateway: Gateway) -> None:
    for _ in range(2):
        CliRunner().invoke(main, ["dock", "--no-wait"])
    first, second = (options["headers"]["Idempotency-Key"] for _, _, options in gateway.requests)
    assert first != second


@pytest.mark.parametrize("url", ["localhost:8000", "http://[::1", "http://localhost:99999"])
def test_what_is_no_address_is_said_in_a_sentence(url: str) -> None:
    result = CliRunner().invoke(main, ["watch", "--url", url])
    assert (result.exit_code, result.output.partition(": ")[0]) == (1, "Error")
    assert f"{url} is not the address of a gateway" in result.output
