"""Nothing in a request keeps robots from being stopped: those that it clearly names, all if that is not clear.

The application and what stops are the real ones, the robots are fakes; tests/system has real ones.
"""

import asyncio
import tempfile
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import orjson
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from dock_gateway.access.carry_out import carry_out
from dock_gateway.access.logins import Logins
from dock_gateway.app import create_app
from dock_gateway.core.access import ANYBODY, Principal, PrincipalKind
from dock_gateway.core.grant import Grant, Role
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import StopTiming
from dock_gateway.streams.commands import COMMANDS, read_command
from tests.support.stopping import FakeFleet, fake_fleet
from tests.support.waiting import until

APP = create_app(Settings())
FIRST, ONE = ["/robot1", "/robot1/arm"], ["/robot2"]
NAMES = (*FIRST, *ONE)
ALL = [*NAMES]
# These say who asks, and whether a page of another origin may; `test_origin.py` is about them.
ABOUT_THE_SENDER = (b"host", b"origin", b"sec-", b"upgrade", b"connection")
NINES = b"9" * 4301
DEEP = b"[" * 1020 + b"]" * 1020


# A stop that a busy machine has not stored yet would be warned of first.
TIMING = StopTiming(store_within=10.0, body_within=60.0)
# For bodies that never come.
IMPATIENT = replace(TIMING, body_within=0.05)


def fleet_in(folder: Path, timing: StopTiming = IMPATIENT) -> AbstractAsyncContextManager[FakeFleet]:
    return fake_fleet(folder / "stops.json", *NAMES, timing=timing)


@dataclass(frozen=True)
class Asked:
    """A request.

    Attributes:
        body: Its pieces.
        end: What comes after them: the end (`complete`), nothing (`never`), or that the client left (`gone`).
        late: Whether the body comes only when robots stand still.
    """

    query: bytes = b""
    headers: tuple[tuple[bytes, bytes], ...] = ()
    body: tuple[bytes, ...] = ()
    end: str = "complete"
    late: bool = False


async def ask(fleet: FakeFleet, asked: Asked) -> tuple[int, Any]:
    """The status and the document of the answer."""
    pieces = [{"type": "http.request", "body": piece, "more_body": True} for piece in asked.body]
    if asked.end == "complete":
        pieces.append({"type": "http.request", "body": b"", "more_body": False})
    elif asked.end == "gone":
        pieces.append({"type": "http.disconnect"})
    sent: list[Any] = []

    async def receive() -> Any:
        if not pieces:
            await asyncio.Event().wait()
        if asked.late:
            await until(lambda: any(fleet.zeros()))
        return pieces.pop(0)

    async def send(message: Any) -> None:
        sent.append(message)

    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": "POST",
        "scheme": "http",
        "path": "/stop",
        "raw_path": b"/stop",
        "root_path": "",
        "query_string": asked.query,
        "headers": [(b"host", b"127.0.0.1:8000"), *asked.headers],
        "client": ("127.0.0.1", 50000),
        "server": ("127.0.0.1", 8000),
        "state": {"parts": fleet.parts},
    }
    await APP(scope, receive, send)
    body = b"".join(message.get("body", b"") for message in sent)
    return sent[0]["status"], orjson.loads(body)


def stopped(asked: Asked, timing: StopTiming = IMPATIENT) -> tuple[int, Any, list[str], list[str]]:
    """The answer, and which robots were told to stand still and which are held. The answer names the former."""

    async def run() -> tuple[int, Any, list[str], list[str]]:
        with tempfile.TemporaryDirectory() as folder:
            async with fleet_in(Path(folder), timing) as fleet:
                status, document = await ask(fleet, asked)
                still = [name for name, zeros in zip(NAMES, fleet.zeros(), strict=True) if zeros]
                if asked.late or asked.end != "complete":  # it began without its body, which may have named others
                    assert {*document["stopped"]} <= {*still}
                else:
                    assert (document["stopped"], document["not_stopped"]) == (
                        still,
                        [each for each in NAMES if each not in still],
                    )
                return status, document, still, [name for name in NAMES if fleet.interlock.holds(name)]

    return asyncio.run(run())


async def command_stop(fleet: FakeFleet, request: object, principal: Principal = ANYBODY) -> dict[str, Any]:
    """Stop as every door but REST does."""
    scope = {"type": "websocket", "state": {"parts": fleet.parts}, "client": None, "headers": []}
    logins: Any = SimpleNamespace(require_valid=lambda _: None, watch=lambda *_: None)
    fleet.parts.replace(Logins, logins)
    fleet.parts.replace(Quotas, Quotas(Settings()))
    return await carry_out(fleet.parts, principal, COMMANDS["stop"], request, scope)


# ---------------------------------------------------------------------- whatever it is, the robot is stopped

anything = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False) | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)
fields = st.dictionaries(st.sampled_from(["latch", "by", "lock"]), anything, max_size=3)
encoded = (fields | anything).map(lambda value: orjson.dumps(value, option=orjson.OPT_NON_STR_KEYS))
bodies = encoded | st.binary(max_size=200) | encoded.map(lambda text: text[:-1])
odd = [b"wait=2", b"wait=" + NINES, NINES, b"-1", b"\xb2", b"wait=\xb2", b"wait=1e999", b"wait=;", b'wait="', b"gzip"]
odd += [b"chunked", b"application/json; charset=utf-7", b"text/xml", b"100-continue"]
values = st.binary(max_size=50) | st.sampled_from(odd)
named = st.sampled_from([b"prefer", b"content-length", b"content-type", b"content-encoding", b"transfer-encoding"])
names = (
    named | st.sampled_from([b"expect", b"accept", b"idempotency-key", b"cookie"]) | st.binary(min_size=1, max_size=9)
)
headers = st.lists(st.tuples(names, values), max_size=5).map(
    lambda found: tuple(one for one in found if not one[0].lower().startswith(ABOUT_THE_SENDER))
)
clear = st.sampled_from([b"", b"robot=/robot2", b"robot=%2Frobot2", b"robot=/robot2&robot=/robot2&x=%ff"])


@settings(max_examples=150)
@given(query=clear, headers=headers, body=bodies, end=st.sampled_from(["complete", "never", "gone"]))
@example(b"", ((b"prefer", b"wait=" + NINES),), b"", "complete")
@example(b"", ((b"prefer", b"wait=2"), (b"prefer", b"wait=\xb2")), b"{}", "complete")
@example(b"", ((b"content-length", NINES),), b"{}", "complete")
@example(b"", (), b'{"latch":' + DEEP + b"}", "complete")
@example(b"", (), b'{"by":' + DEEP + b"}", "complete")
@example(b"robot=/robot2", ((b"content-type", b"text/html"),), b"<html>", "never")
def test_a_robot_that_is_clearly_named_is_stopped(
    query: bytes, headers: tuple[tuple[bytes, bytes], ...], body: bytes, end: str
) -> None:
    status, document, still, held = stopped(Asked(query, headers, (body,), end))
    meant = ONE if query else ALL
    assert (status, document["failed"]) == (200, [])
    assert still == meant
    latches = document["stop"]["latched"]
    assert held == (meant if latches else [])
    assert latches or b'"latch":false' in body


# ---------------------------------------------------------------------- what is made of it

JSON = (b"content-type", b"application/json")


@pytest.mark.parametrize(
    ("body", "latched", "by", "wrong"),
    [
        (b"", True, None, None),
        (b"{}", True, None, None),
        (b'{"latch": false, "by": " Ada "}', False, None, None),
        (b'{"by": " Ada "}', True, "Ada", None),
        (b'{"by": null}', True, None, None),
        (b'{"latch": "false"}', True, None, "latch"),
        (b'{"latch": false, "by": "' + b"a" * 101 + b'"}', True, None, "by"),
        (b'{"latch": false, "lock": 1}', True, None, "lock"),
        (b"[]", True, None, ""),
        (b"null", True, None, ""),
    ],
)
def test_how_it_stops(body: bytes, latched: bool, by: str | None, wrong: str | None) -> None:
    status, document, still, _ = stopped(Asked(headers=(JSON,), body=(body,)))
    assert (status, still) == (200, ALL)
    assert (document["stop"]["latched"], document["stop"]["by"]) == (latched, by)
    warning = document["warning"]
    assert (warning and warning["errors"][0]["path"]) == wrong


async def _nothing(_: str | None) -> None:
    pass


@pytest.mark.parametrize(
    "body", [b"", b"{", b"[]", b'{"latch": 1}', b'{"lock": 1}', b'{"by": 7}', b'{"by": "mallory"}']
)
async def test_who_is_known_is_named_whatever_the_body(tmp_path: Path, body: bytes) -> None:
    ada = Principal("ada", PrincipalKind.USER, Grant(Role.VIEWER), "id")
    async with fleet_in(tmp_path) as fleet:
        fleet.parts.replace(Settings, Settings(authentication=True, database_url="sqlite:////nowhere"))
        logins: Any = SimpleNamespace(prepare=_nothing, identify=lambda _: ada)
        fleet.parts.replace(Logins, logins)
        _, document = await ask(fleet, Asked(headers=(JSON,), body=(body,)))
        assert (document["stop"]["latched"], document["stop"]["by"]) == (True, "ada")
        entry = fleet.audit.entries[-1]  # a busy machine reads the body late
        assert (entry.what, entry.principal, entry.status) == ("stop", "ada", 200)


async def test_who_is_known_is_named_on_a_websocket_too(tmp_path: Path) -> None:
    ada = Principal("ada", PrincipalKind.USER, Grant(Role.VIEWER), "id")
    async with fleet_in(tmp_path) as fleet:
        report = await command_stop(fleet, {"latch": 1, "by": "mallory"}, ada)
        assert (report["stop"]["latched"], report["stop"]["by"]) == (True, "ada")


@pytest.mark.parametrize(
    ("asked", "code", "detail"),
    [
        (Asked(body=(b"{",)), "malformed_json", "not JSON"),
        (Asked(body=(b"{",), end="never"), "request_timeout", "did not arrive"),
        (Asked(body=(b"{",), end="gone"), "malformed_json", "connection was closed"),
        (Asked(headers=((b"content-type", b"text/xml"),), body=(b"{}",)), "unsupported_media_type", "text/xml"),
        (Asked(headers=((b"content-length", NINES),), body=(b"{}",)), "body_too_large", "larger"),
        (Asked(headers=((b"prefer", b"wait=soon"),)), "invalid_field", "Prefer"),
        (Asked(query=b"robot=/robot1&robot=/robot2&now=1"), "invalid_field", "now"),
    ],
)
def test_what_was_wrong_is_a_warning(asked: Asked, code: str, detail: str) -> None:
    status, document, still, held = stopped(asked)
    assert (status, still, held) == (200, ALL, ALL)
    assert document["warning"]["code"] == code
    assert detail in document["warning"]["detail"]


def test_all_that_was_wrong_is_one_warning() -> None:
    warning = stopped(Asked(b"robot=/robot1&x=1", ((b"prefer", b"wait=x"),), (b'{"latch": 1}',)))[1]["warning"]
    places = [(error["in"], error["path"]) for error in warning["errors"]]
    assert places == [("header", "Prefer"), ("query", "x"), ("body", "latch")]


# ---------------------------------------------------------------------- which robot


@pytest.mark.parametrize(
    ("query", "body", "robots"),
    [
        (b"", b'{"robot": "/robot2"}', ONE),
        (b"robot=/robot2", b'{"robot": "/robot2"}', ONE),
        (b"", b'{"robot": ["/robot2", "robot1/arm"]}', ["/robot1/arm", *ONE]),
        (b"", b'{"robot": [" /robot2 ", null]}', ONE),
        (b"robot=/robot2", b'{"robot": null}', ONE),
        (b"robot=/robot2", b'{"robot": "/robot1/arm"}', ["/robot1/arm", *ONE]),
        (b"robot=/robot2&robto=/robot1", b'{"robots": "/robot1"}', ONE),
        (b"robot=/robot1/arm", b"", ["/robot1/arm"]),
        (b"robot=robot2", b"", ONE),
        (b"robot=robot1/arm/&robot=//robot2", b"", ["/robot1/arm", *ONE]),
        (b"", b'{"robot": "robot2"}', ONE),
        (b"robot=/robot1/arm&robot=/robot2&robot=/robot2", b"", ["/robot1/arm", *ONE]),
        (b"robot=/robot1/arm&robot=/robot1", b"", FIRST),
        (b"", b"", ALL),
        (b"robot=/", b"", ALL),
        (b"robot=/&robot=/robot2", b"", ALL),
    ],
)
def test_the_robot_that_is_meant(query: bytes, body: bytes, robots: list[str]) -> None:
    status, _, still, held = stopped(Asked(query, body=(body,)))
    assert (status, still, held) == (200, robots, robots)


def test_a_robot_that_is_not_known_keeps_none_of_the_others_from_being_stopped() -> None:
    status, document, still, held = stopped(Asked(b"robot=/robot7&robot=/robot2&robot=/robot1/arm"))
    assert (status, still, held) == (200, ["/robot1/arm", *ONE], ["/robot1/arm", *ONE])
    assert [(each["robot"], each["code"]) for each in document["failed"]] == [("/robot7", "robot_not_found")]
    assert (document["stop"]["latched"], document["stop"]["robots"]) == (True, ["/robot1/arm", *ONE])


@pytest.mark.parametrize(
    ("query", "body", "robots", "by"),
    [
        (b"", b'{"by": "Ada"}', (ALL, ALL), "Ada"),
        (b"robot=/robot1", b'{"by": "Ada"}', (FIRST, FIRST), "Ada"),
        (b"robot=/robot2", b'{"by": "Ada"}', (ONE, ONE), "Ada"),
        (b"robot=/robot2", b'{"latch": false}', (ONE, []), None),
        (b"", b'{"robot": "/robot2", "by": "Ada"}', ([*NAMES], ONE), "Ada"),
        (b"robot=/robot2&robot=/robot1/arm", b'{"by": "Ada"}', (["/robot1/arm", *ONE],) * 2, "Ada"),
    ],
)
def test_a_stop_does_not_wait_for_its_body_and_obeys_it_when_it_comes(
    query: bytes, body: bytes, robots: tuple[list[str], list[str]], by: str | None
) -> None:
    status, document, still, held = stopped(Asked(query, (JSON,), (body,), late=True), TIMING)
    assert (status, document["warning"], document["stop"]["by"]) == (200, None, by)
    assert (still, held) == robots


@pytest.mark.parametrize(
    ("asked", "began", "ended"),
    [
        (Asked(body=(b"{}",), late=True), "/", ("/", 200)),
        (Asked(body=(b'{"robot": "/robot2"}',), late=True), "/", ("/robot2", 200)),
        (Asked(body=(b'{"robot": 7}',), late=True), "/", ("/", 200)),
        (Asked(b"robot=/robot2", body=(b'{"robot": 7}',), late=True), "/robot2", ("/", 200)),
        (Asked(b"robot=/robot2&robot=/robot1", late=True), "/robot2,/robot1", ("/robot2,/robot1", 200)),
    ],
)
async def test_a_stop_whose_body_comes_late_is_recorded_as_it_begins_and_as_its_body_says(
    tmp_path: Path, asked: Asked, began: str, ended: tuple[str, int]
) -> None:
    async with fleet_in(tmp_path, TIMING) as fleet:
        await ask(fleet, asked)
        entries = fleet.audit.entries
        assert [(entry.what, entry.robot, entry.status) for entry in entries] == [
            ("stop", began, 200),
            ("stop", *ended),
        ]


async def test_a_stop_whose_body_never_comes_is_recorded_before_it_is_waited_for(tmp_path: Path) -> None:
    async with fleet_in(tmp_path, TIMING) as fleet:
        asking = asyncio.create_task(ask(fleet, Asked(body=(b"{",), end="never")))
        await until(lambda: fleet.audit.entries)
        assert not asking.done()
        (entry,) = fleet.audit.entries
        assert (entry.what, entry.status, entry.outcome) == ("stop", 200, "done")
        asking.cancel()


@pytest.mark.parametrize(
    ("query", "body", "code"),
    [
        (b"robot=/robot1&robot=", b"", "invalid_field"),
        (b"robot=a%20b&robot=/robot2", b"", "invalid_field"),
        (b"robto=/robot2", b"", "invalid_field"),
        (b"", b'{"robot": 7}', "invalid_field"),
        (b"", b'{"robot": ["/robot1", ["/robot2"]]}', "invalid_field"),
        (b"", b'{"robot": {"name": "/robot1"}}', "invalid_field"),
        (b"", b'{"robots": "/robot1"}', "invalid_field"),
        (b"", b'"/robot1"', "invalid_field"),
        (b"robot=/robot1", b'{"robot": 7}', "invalid_field"),
        (b"robot=", b"", "invalid_field"),
        (b"&".join(b"robot=/r%d" % number for number in range(1001)), b"", "invalid_field"),
        (b"robot=/robot7", b"", "robot_not_found"),
        (b"robot=/robot7&robot=/robot8", b"", "robot_not_found"),
    ],
)
def test_all_robots_are_stopped_where_it_is_not_clear_which(query: bytes, body: bytes, code: str) -> None:
    answer, document, still, held = stopped(Asked(query, body=(body,)))
    assert (answer, still, held) == (200, ALL, ALL)
    assert document["warning"]["code"] == code
    assert "ll robots are stopped" in document["warning"]["detail"]


# ---------------------------------------------------------------------- on `/ws`


@pytest.mark.parametrize(
    ("command", "latched", "wrong"),
    [
        ({"robot": "/robot2"}, True, []),
        ({"robot": "/robot2", "latch": False}, False, []),
        ({"robot": "/robot2", "id": 7}, True, ["id"]),
        ({"robot": "/robot2", "id": "i" * 201, "latch": None}, True, ["latch", "id"]),
        ({"robot": "/robot2", "wait": 2, "by": [[]]}, True, ["by", "wait"]),
        ({"robot": "/robot2", **{f"k{number}": 1 for number in range(200)}}, True, [f"k{n}" for n in range(20)]),
    ],
)
async def test_a_stop_on_a_websocket(tmp_path: Path, command: dict[str, Any], latched: bool, wrong: list[str]) -> None:
    async with fleet_in(tmp_path) as fleet:
        _, _, request = read_command({"op": "stop", **command})
        report = await command_stop(fleet, request)
        assert fleet.zeros()[:2] == [0, 0]
        assert fleet.zeros()[2] >= 1
        assert fleet.interlock.holds("/robot2") is latched
        assert [error["path"] for error in (report["warning"] or {}).get("errors", [])] == wrong


@pytest.mark.parametrize(
    "command", [{"robots": "/robot2"}, {"robot": 7}, {"robot": None, "id": 7, "wait": 2}, {"robot": "/robot7"}]
)
async def test_all_robots_are_stopped_by_a_websocket_where_it_is_not_clear_which(
    tmp_path: Path, command: dict[str, Any]
) -> None:
    async with fleet_in(tmp_path) as fleet:
        _, _, request = read_command({"op": "stop", **command})
        report = await command_stop(fleet, request)
        assert min(fleet.zeros()) >= 1
        assert report["warning"] is not None
