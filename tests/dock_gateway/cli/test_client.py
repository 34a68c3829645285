"""The command line as a client: a Ctrl-C always cancels."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
import orjson
import pytest
from click.testing import CliRunner

from dock_gateway.cli import main, stored_tokens
from dock_gateway.cli.events import EventPrinter, lines_of
from dock_gateway.cli.stop import describe
from dock_gateway.client import sync
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import Goal, GoalStatus, encode

ID = "7d9c1c9e-0000-4000-8000-000000000000"
NOW = utc_now()
GOAL = Goal(ID, "/dock", "pkg/action/Dock", NOW, status=GoalStatus.CANCELED, finished_at=NOW).document()
CHARGING = {"power_supply_status": 1, "voltage": None, "percentage": None}
PUBLISHED = {"state": CHARGING, "rate_hz": 2.0}
EVENTS = [{"type": "snapshot", "time": NOW, "goals": [GOAL]}]


class Gateway:
    """In place of the network: keeps what is sent, and can let the user press Ctrl-C while it is."""

    def __init__(self) -> None:
        self.requests: list[tuple[str, str, dict[str, Any]]] = []
        self.interrupted: Callable[[int], bool] = lambda number: False
        self.answers: dict[str, Any] = {}

    def request(self, http: httpx2.Client, method: str, path: str, **options: Any) -> httpx2.Response:
        target = http.build_request(method, path, params=options["params"]).url.raw_path.decode().removeprefix("/")
        self.requests.append((method, target, options))
        if self.interrupted(len(self.requests)):
            raise KeyboardInterrupt
        return httpx2.Response(200, content=encode(self.answers.get(target.partition("?")[0], GOAL)))

    @contextmanager
    def connect(self, _: str, **options: Any) -> Iterator["Gateway"]:
        self.events = map(encode, EVENTS)
        yield self

    def recv(self, _: float | None) -> bytes:
        return next(self.events)


@pytest.fixture
def gateway(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Gateway:
    gateway = Gateway()

    def request(http: httpx2.Client, method: str, path: str, **options: Any) -> httpx2.Response:
        return gateway.request(http, method, path, **options)

    monkeypatch.setattr(httpx2.Client, "request", request)
    monkeypatch.setattr(sync, "connect", gateway.connect)
    for name in ("URL", "TOKEN"):
        monkeypatch.delenv(f"DOCK_GATEWAY_{name}", raising=False)
    monkeypatch.setattr(stored_tokens, "token_file", lambda: tmp_path / "config/tokens.json")
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
def test_what_is_shown_of_a_status(status: str, stage: str | None, error: dict[str, str] | None, line: str) -> None:
    event = {"type": "status", "goal_id": ID, "status": status, "stage": stage, "error": error}
    assert lines_of(event) == [line]


def test_feedback_that_reads_as_before_is_printed_once(capsys: pytest.CaptureFixture[str]) -> None:
    def feedback(goal_id: str, voltage: float) -> dict[str, Any]:
        return {"type": "feedback", "goal_id": goal_id, "feedback": {"voltage": voltage}}

    events = [feedback(goal_id, voltage) for voltage in (1.0, 1.0, 2.0, 1.0) for goal_id in (ID, "another")]
    for as_json, count in ((False, 6), (True, 8)):
        printer = EventPrinter(as_json=as_json)
        for event in events:
            printer.show(event)
        assert len(capsys.readouterr().out.splitlines()) == count


@pytest.mark.parametrize(
    ("stopped", "canceling", "line"),
    [
        ([], [], "no robot was stopped: there is none that you may see"),
        (["/"], [], "stopped / (the robot without a namespace): zero velocity; no goal ran"),
        (["/a", "/b"], [ID], "stopped /a, /b: zero velocity; canceling 1 goal"),
        (["/a"], [ID, "x"], "stopped /a: zero velocity; canceling 2 goals"),
    ],
)
def test_a_stop_says_who_was_stopped(stopped: list[str], canceling: list[str], line: str) -> None:
    assert describe(stopped, canceling) == line


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


@pytest.mark.parametrize(
    ("arguments", "method", "path", "body"),
    [
        (["dock"], "POST", "dock", None),
        (["dock", "/robot1", "--dock", "lab"], "POST", "dock?robot=%2Frobot1", {"dock_id": "lab"}),
        (
            ["dock", "--robot", "/robot1", "--until", "full"],
            "POST",
            "dock?robot=%2Frobot1",
            {"desired_battery_state": {"power_supply_status": 4, "voltage": None, "percentage": None}},
        ),
        (["undock", "/robot2"], "POST", "undock?robot=%2Frobot2", None),
        (["send", "/fibonacci", "{order: 5}"], "POST", "actions/fibonacci/goals", {"order": 5}),
        (["send", "/fibonacci"], "POST", "actions/fibonacci/goals", {}),
        (["battery", "publish", "--status", "charging", "--robot", "/r"], "POST", "battery?robot=%2Fr", CHARGING),
        (["battery", "--robot", "/r", "publish", "--status", "1"], "POST", "battery?robot=%2Fr", CHARGING),
        (
            ["battery", "publish", "--status", "1", "--rate", "2"],
            "PUT",
            "battery/publisher",
            {"state": CHARGING, "rate_hz": 2.0},
        ),
        (["battery", "unpublish"], "DELETE", "battery/publisher", None),
        (["goal", ID], "GET", f"goals/{ID}", None),
        (["cancel", ID], "POST", f"goals/{ID}/cancel", None),
        (["api", "/statistics", "-f", "by=robot", "-f", "by=hour"], "GET", "statistics?by=robot&by=hour", None),
        (
            ["api", "POST", "/dock?robot=/r", "-f", "dock_id=lab", "-f", "n=[1]"],
            "POST",
            "dock?robot=%2Fr",
            {"dock_id": "lab", "n": [1]},
        ),
        (["api", "delete", "stop", "-f", "robot=/r"], "DELETE", "stop?robot=%2Fr", None),
        (["api", "PUT", "/x", "--body", '{"a": null}'], "PUT", "x", {"a": None}),
        (["release", "/robot1"], "DELETE", "stop?robot=%2Frobot1", None),
    ],
)
def test_what_a_command_sends(
    gateway: Gateway, arguments: list[str], method: str, path: str, body: dict[str, Any] | None
) -> None:
    wait = [] if arguments[0] not in ("dock", "undock", "send") else ["--no-wait"]
    result = CliRunner().invoke(main, [*arguments, *wait])
    assert result.exit_code == 0, result.output
    sent, where, options = gateway.requests[-1] if arguments[0] != "cancel" else gateway.requests[1]
    assert (sent, where) == (method, path)
    assert orjson.loads(options.get("content", "null")) == body


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["dock", "/a", "--robot", "/b"], "both /a and /b are named"),
        (["send", "/fibonacci", "5"], "not like '{order: 5}'"),
        (["send", "/fibonacci", "{"], "not YAML"),
        (["battery", "publish"], "Missing option '--status'"),
        (["api", "FETCH", "/dock"], "write a method"),
        (["api", "POST", "/dock", "-f", "lab"], "not like dock_id=lab"),
        (["api", "POST", "/dock", "--body", "{"], "not JSON"),
        (["goals", "--since", "soon"], "no time such as"),
        (["--url", "http://127.0.0.1:1", "serve"], "serve asks no gateway: leave out --url"),
        (["--json", "up"], "up asks no gateway: leave out --json"),
    ],
)
def test_a_wrong_command_line_sends_nothing(gateway: Gateway, arguments: list[str], sentence: str) -> None:
    result = CliRunner().invoke(main, arguments)
    assert (result.exit_code, sentence in result.output) == (2, True), result.output
    assert gateway.requests == []


@pytest.mark.parametrize("arguments", [["--json", "goal", ID], ["goal", ID, "--json"]])
def test_json_and_url_may_stand_before_or_after_the_command(gateway: Gateway, arguments: list[str]) -> None:
    printed = CliRunner().invoke(main, arguments).output
    assert orjson.loads(printed)["goal_id"] == ID
    for where in (["--url", "http://h", "alerts"], ["alerts", "--url", "http://h"]):
        gateway.answers["alerts"] = {"alerts": []}
        assert "no active alerts" in CliRunner().invoke(main, where).output


def test_cancel_without_an_id_is_the_only_goal_that_runs(gateway: Gateway) -> None:
    gateway.answers["goals"] = {"goals": []}
    assert "no goal is running" in CliRunner().invoke(main, ["cancel"]).output
    gateway.answers["goals"] = {"goals": [GOAL, GOAL | {"goal_id": "another"}]}
    refused = CliRunner().invoke(main, ["cancel"])
    assert (refused.exit_code, "another" in refused.output) == (1, True)
    gateway.answers["goals"] = {"goals": [GOAL]}
    assert CliRunner().invoke(main, ["cancel", "--robot", "/r"]).exit_code == 0
    assert [path.split("&")[-1] for _, path, _ in gateway.requests][-3:] == [
        "robot=%2Fr",
        f"goals/{ID}",
        f"goals/{ID}/cancel",
    ]


def test_goals_are_a_table(gateway: Gateway) -> None:
    failed = GOAL | {"status": "aborted", "error": {"code": "blocked", "detail": "x"}}
    gateway.answers["goals"] = {"goals": [GOAL, failed], "next_cursor": None}
    lines = (
        CliRunner().invoke(main, ["goals", "--robot", "/r", "--status", "running", "--since", "2h"]).output.splitlines()
    )
    assert [line.split()[0] for line in lines] == ["GOAL", ID, ID]
    assert lines[2].endswith("blocked")
    _, path, _ = gateway.requests[0]
    assert "status=executing" in path
    assert "since=" in path


@pytest.mark.parametrize("principal", [None, {"name": "ada", "role": "operator"}])
def test_a_login_is_stored_for_its_gateway_and_only_for_the_user(
    gateway: Gateway, tmp_path: Path, principal: dict[str, str] | None
) -> None:
    gateway.answers["session"] = {"principal": principal, "required": True}
    file = tmp_path / "config/tokens.json"
    result = CliRunner().invoke(main, ["login", "--url", "http://h:1/"], input="dgw_secret\n")
    if principal is None:
        assert (result.exit_code, file.exists()) == (1, False)
        return
    assert "logged in at http://h:1 as ada (operator)" in result.output
    assert "dgw_secret" not in result.output
    assert file.stat().st_mode & 0o777 == 0o600
    assert stored_tokens.stored_token("http://h:1") == "dgw_secret"
    assert stored_tokens.stored_token("http://other") is None
    assert "forgotten" in CliRunner().invoke(main, ["logout", "--url", "http://h:1"]).output
    assert stored_tokens.stored_token("http://h:1") is None


def test_a_stop_imports_little() -> None:
    """What is imported takes time, in which robots move."""
    code = "import sys; import dock_gateway.cli.stop; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {
        "pydantic",
        "pydantic_settings",
        "fastapi",
        "sqlalchemy",
        "numpy",
        "yaml",
        "dock_gateway.settings",
        "rclpy",
    }
    assert not heavy & set(done.stdout.split())
