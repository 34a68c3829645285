"""How long a client waits: as long as it was asked to, at a server that is slow, frozen or gone."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.client import AsyncClient, Client, ClientError, ClientTimeout, GatewayUnreachable, calls
from dock_gateway.client.calls import Call
from tests.support.processes import free_port

# Of a client, for its answers and without the gateway; and what a busy machine needs in addition.
TIMEOUT, PATIENCE, SLACK = 0.4, 0.5, 1.5
NOW = "2026-11-28T00:00:00Z"
GOAL = {
    "goal_id": "7d9c1c9e-0000-4000-8000-000000000000",
    "action_name": "/fibonacci",
    "action_type": "a/action/B",
    "robot": "/",
    "verb": None,
    "status": "executing",
    "stalled": False,
    "stage": None,
    "retries": None,
    "origin": "gateway",
    "goal": {},
    "feedback": None,
    "feedback_count": 0,
    "result": None,
    "error": None,
    "outcome": None,
    "notes": [],
    "created_at": NOW,
    "updated_at": NOW,
    "finished_at": None,
    "last_event_id": None,
    "tags": [],
}


class SlowServer:
    """Answers every request after some seconds, if at all. `asked` has the time and the headers of each."""

    def __init__(self) -> None:
        self.delay = 0.0
        self.answer: object = {}
        self.asked: list[tuple[float, dict[str, str]]] = []
        self.ended = threading.Event()
        slow = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:
                slow.asked.append((time.monotonic(), dict(self.headers)))
                self.rfile.read(int(self.headers.get("content-length", 0)))
                if slow.ended.wait(slow.delay):
                    return
                content = orjson.dumps(slow.answer)
                with suppress(OSError):
                    self.send_response(200)
                    self.send_header("Content-Length", str(len(content)))
                    self.end_headers()
                    self.wfile.write(content)

            do_POST = do_PATCH = do_DELETE = do_GET  # noqa: N815 - as the base class names them

            def log_message(self, format: str, *args: object) -> None:  # noqa: A002 - its name in the standard library
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        self._thread = threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.01})
        self._thread.start()

    def close(self) -> None:
        self.ended.set()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


@pytest.fixture
def server() -> Iterator[SlowServer]:
    server = SlowServer()
    yield server
    server.close()


def of_sync(url: str, ask: Callable[[Any], Any]) -> Any:
    with Client(url, timeout=TIMEOUT, patience=PATIENCE) as client:
        return ask(client)


def of_asyncio(url: str, ask: Callable[[Any], Any]) -> Any:
    async def run() -> Any:
        async with AsyncClient(url, timeout=TIMEOUT, patience=PATIENCE) as client:
            return await ask(client)

    return asyncio.run(run())


BOTH = pytest.mark.parametrize("run", [of_sync, of_asyncio])
Run = Callable[[str, Callable[[Any], Any]], Any]


def seconds_until_timeout(run: Run, url: str, ask: Callable[[Any], Any]) -> float:
    began = time.monotonic()
    with pytest.raises(ClientTimeout, match="has not answered within") as timed_out:
        run(url, ask)
    assert isinstance(timed_out.value, ClientError)
    assert isinstance(timed_out.value, TimeoutError)
    return time.monotonic() - began


# What is asked, and for how many seconds the gateway may wait by itself.
WAITS: dict[str, tuple[Callable[[Any], Any], float]] = {
    "a service": (lambda client: client.call_service("/reset", timeout=1), 1),
    "the end of a goal": (lambda client: client.request("POST", "/dock", {}, wait=1), 1),
    "a stop": (lambda client: client.stop(), 2),
    "a release": (lambda client: client.release(), 0),
    "a message": (lambda client: client.publish("/chatter", {}), 0),
    "any request": (lambda client: client.request("GET", "/statistics"), 0),
    "robots": (lambda client: client.robots(), 0),
    "a battery": (lambda client: client.battery(), 0),
}


@BOTH
@pytest.mark.parametrize("what", WAITS)
def test_an_answer_may_take_as_long_as_was_asked(server: SlowServer, run: Run, what: str) -> None:
    ask, wait = WAITS[what]
    server.delay = 60
    assert TIMEOUT + wait <= seconds_until_timeout(run, server.url, ask) < TIMEOUT + wait + SLACK
    assert len(server.asked) == 1


@BOTH
def test_what_comes_in_that_time_is_returned(server: SlowServer, run: Run) -> None:
    server.delay, server.answer = TIMEOUT + 0.8, {"response": {"done": True}}
    assert run(server.url, lambda client: client.call_service("/reset", timeout=2)) == {"done": True}
    server.answer = {"status": "succeeded"}
    assert run(server.url, lambda client: client.request("POST", "/dock", {}, wait=2)) == server.answer
    assert server.asked[-1][1]["Prefer"] == "wait=2"


@BOTH
@pytest.mark.parametrize("what", ["parameters", "set_parameters"])
def test_a_node_may_be_slow(server: SlowServer, run: Run, what: str) -> None:
    values = () if what == "parameters" else ({"speed": 1},)
    server.delay, server.answer = 4 * TIMEOUT, {"parameters": [{"name": "speed", "value": 1}]}
    assert run(server.url, lambda client: getattr(client, what)("/base", *values)) == {"speed": 1}
    assert len(server.asked) == 1


@BOTH
def test_a_goal_that_waits_for_a_person_is_asked_for_again_with_its_key(
    server: SlowServer, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also by a client that this gateway has never answered: the first thing that an agent's script does is to dock."""
    monkeypatch.setattr(calls, "APPROVAL", 3 * TIMEOUT)
    server.delay = 60
    taken = seconds_until_timeout(run, server.url, lambda client: client.dock())
    assert 4 * TIMEOUT <= taken < 5 * TIMEOUT + SLACK
    assert len(server.asked) >= 2
    assert len({headers["Idempotency-Key"] for _, headers in server.asked}) == 1

    def allow() -> None:
        server.delay = 0.0

    server.answer = GOAL
    server.asked.clear()
    threading.Timer(2 * TIMEOUT, allow).start()
    assert run(server.url, lambda client: client.send("/fibonacci", {})).id == GOAL["goal_id"]
    assert len({headers["Idempotency-Key"] for _, headers in server.asked}) == 1


@BOTH
def test_a_question_is_repeated_until_patience_ends_where_the_gateway_was_there(server: SlowServer, run: Run) -> None:
    server.answer = {"robots": []}

    def both(client: Any) -> Any:
        if isinstance(client, Client):
            client.robots()
            server.delay = 60
            return client.robots()

        async def ask() -> Any:
            await client.robots()
            server.delay = 60
            return await client.robots()

        return ask()

    taken = seconds_until_timeout(run, server.url, both)
    assert PATIENCE <= taken < 2 * TIMEOUT + PATIENCE + SLACK
    assert len(server.asked) >= 3


@BOTH
@pytest.mark.parametrize("ask", [ask for ask, _ in WAITS.values()], ids=list(WAITS))
def test_a_gateway_that_is_not_there_is_unreachable_at_once(run: Run, ask: Callable[[Any], Any]) -> None:
    began = time.monotonic()
    with pytest.raises(GatewayUnreachable, match="no gateway answers"):
        run(f"http://127.0.0.1:{free_port()}", ask)
    assert time.monotonic() - began < SLACK


def test_the_wait_for_a_goal_ends_in_time_though_nothing_answers(server: SlowServer) -> None:
    """Neither the handshake of its stream nor the question that follows makes it longer."""
    server.answer = GOAL
    with Client(server.url, timeout=30) as client:
        goal = client.goal(GOAL["goal_id"])
        server.delay = 60
        for ask in (goal.wait, goal.result, lambda timeout: list(goal.events(timeout=timeout))):
            began = time.monotonic()
            with pytest.raises(ClientTimeout, match="the goal has not ended in time"):
                ask(0.5)
            assert 0.5 - 0.05 <= time.monotonic() - began < 0.5 + SLACK


@given(st.floats(0.001, 300))
def test_no_request_is_shorter_than_the_wait_that_it_asks_for(seconds: float) -> None:
    """Whatever names a wait in its query or its headers has it in `wait`, too."""
    every: list[Call[Any]] = [
        calls.call_service("/a", None, seconds),
        calls.request("GET", "/goals", None, None, int(seconds)),
        calls.stop((), None, latch=True),
        calls.send("/dock", None, None, None),
        calls.parameters("/a"),
        calls.set_parameters("/a", {}),
    ]
    for call in every:
        preferred = float(call.headers.get("Prefer", "wait=0").removeprefix("wait="))
        assert call.wait >= max(preferred, float(str(call.params.get("timeout", 0))))
