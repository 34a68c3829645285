"""An extension can be taken out; one that fails is left out; each kind of thing that one adds is documented."""

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import fields
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fastapi import APIRouter
from fastapi.testclient import TestClient
from pydantic import create_model
from starlette.responses import Response

from dock_gateway import extension as extension_module
from dock_gateway import extension_list
from dock_gateway.app import create_app
from dock_gateway.cli.options import TYPE
from dock_gateway.core.grant import Role
from dock_gateway.extension import Extension, Installed, extensions
from dock_gateway.extension_list import GROUP, OURS
from dock_gateway.fleet import alert_kinds
from dock_gateway.http.operation import DuplicateRoute, Scope, Undeclared, operation
from dock_gateway.http.parts import Part as RoutePart
from dock_gateway.http.parts import Parts
from dock_gateway.http.route import ApiRoute
from dock_gateway.settings import ExtensionSettings, Settings
from tests.support.audit import audit_parts

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/write-an-extension.md"


@pytest.fixture(scope="module")
def full() -> dict[str, Any]:
    """The document of a gateway with all of them."""
    return create_app(Settings(), installed=extensions()).openapi()


@pytest.mark.parametrize("extension", [*extensions()], ids=lambda extension: extension.name)
def test_the_gateway_is_complete_without_each(extension: Extension, full: dict[str, Any]) -> None:
    """Its routes, events and alerts are gone, and all others are as they were."""
    installed = Installed(other for other in extensions() if other is not extension)
    left = create_app(Settings(), installed=installed).openapi()
    own = {route.path_format for router in extension.routes(Settings()) for route in router.routes}  # type: ignore[attr-defined]
    assert left["paths"] == {path: item for path, item in full["paths"].items() if path not in own}
    kinds = full["components"]["schemas"]["AlertKind"]["enum"]
    expected = [kind for kind in kinds if kind not in {each.value for each in extension.alerts}]
    assert left["components"]["schemas"]["AlertKind"]["enum"] == expected
    assert not {event.__name__ for event in extension.events} & left["components"]["schemas"].keys()


@pytest.mark.parametrize("name", OURS)
def test_each_has_a_page_and_tests(name: str) -> None:
    assert (ROOT / f"docs/extensions/{name}.md").exists()
    assert list((ROOT / "tests/extensions" / name).rglob("test_*.py")) or list(ROOT.glob(f"tests/*/test_*{name}*.py"))


@pytest.mark.parametrize("extension", [*extensions()], ids=lambda extension: extension.name)
def test_its_settings_are_those_of_the_gateway(extension: Extension) -> None:
    if extension.settings is not None:
        assert issubclass(TYPE, extension.settings)


def test_each_kind_of_thing_that_one_adds_has_a_heading() -> None:
    headings = re.findall(r"^### (\w+)$", PAGE.read_text(), re.MULTILINE)
    assert headings == [field.name for field in fields(Extension)]


def test_the_code_of_the_page_works() -> None:
    names: dict[str, Any] = {"__name__": "page"}
    for block in re.findall(r"(?ms)^```python\n(.*?)^```$", PAGE.read_text()):
        exec(block, names)
    names["test_only_success_counts"]()
    assert [name for name, value in names.items() if isinstance(value, Extension)] == ["extension"]


class Part:
    """What an extension opens."""


@asynccontextmanager
async def works(_: Parts) -> AsyncIterator[Part]:
    yield Part()


@asynccontextmanager
async def fails(_: Parts) -> AsyncIterator[object]:
    raise OSError("the folder is not there")
    yield


async def test_one_that_fails_is_an_alert_and_the_others_are_open() -> None:
    parts = Parts({})
    async with AsyncExitStack() as stack:
        installed = Installed([Extension("bad", fails), Extension("good", works)])
        await installed.open(parts, stack)
    assert isinstance(parts[Part], Part)
    (alert,) = installed.alerts()
    assert alert.kind is alert_kinds.EXTENSION_FAILED
    assert "bad could not be opened" in alert.detail
    assert "the folder is not there" in alert.detail


async def test_one_whose_part_is_there_already_is_an_alert_and_is_closed() -> None:
    closed: list[str] = []

    @asynccontextmanager
    async def opens_another(_: Parts) -> AsyncIterator[Part]:
        try:
            yield Part()
        finally:
            closed.append("bad")

    parts = Parts({})
    async with AsyncExitStack() as stack:
        installed = Installed([Extension("good", works), Extension("bad", opens_another)])
        await installed.open(parts, stack)
        assert closed == ["bad"]
    assert [alert.title for alert in installed.alerts()] == ["No bad"]


@asynccontextmanager
async def hangs(_: Parts) -> AsyncIterator[object]:
    await asyncio.Event().wait()
    yield


@asynccontextmanager
async def hangs_at_its_end(_: Parts) -> AsyncIterator[Part]:
    yield Part()
    await asyncio.Event().wait()


async def test_one_that_hangs_keeps_the_gateway_from_neither_its_start_nor_its_end(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(extension_module, "OPEN_WITHIN", 0.05)
    monkeypatch.setattr(extension_module, "CLOSE_WITHIN", 0.05)
    parts = Parts({})
    async with asyncio.timeout(10), AsyncExitStack() as stack:
        installed = Installed([Extension("slow", hangs), Extension("good", hangs_at_its_end)])
        await installed.open(parts, stack)
        assert isinstance(parts[Part], Part)
    (alert,) = installed.alerts()
    assert "slow could not be opened" in alert.detail
    assert "not open within 0.05 s" in alert.detail
    assert "the extension good was not closed within 0.05 s" in caplog.text


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    """The name of an extension whose module cannot be imported."""
    (tmp_path / "broken_extension.py").write_text("import nothing_of_this_name\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("DOCK_GATEWAY_EXTENSIONS", "broken")
    found = EntryPoint("broken", "broken_extension:extension", GROUP)
    monkeypatch.setattr(extension_list, "find_entry_point", lambda _: found)
    monkeypatch.setattr(extension_module, "find_entry_point", lambda _: found)
    return "broken"


def test_one_that_cannot_be_imported_is_an_alert_and_the_others_are_there(broken: str) -> None:
    installed = extensions()
    (alert,) = installed.alerts()
    assert alert.kind is alert_kinds.EXTENSION_FAILED
    assert "broken could not be opened" in alert.detail
    assert "nothing_of_this_name" in alert.detail
    assert installed.names == [*OURS, broken]
    create_app(Settings(), installed=installed)
    assert issubclass(extension_list.settings_type.__wrapped__(), Settings), "the options of the command line"


async def test_one_whose_routes_cannot_be_imported_is_an_alert() -> None:
    def routes(_: Settings) -> list[APIRouter]:
        raise ImportError("no module named mcp")

    installed = Installed([Extension("bad", works, routes=routes)])
    create_app(Settings(), installed=installed)
    parts = Parts({})
    async with AsyncExitStack() as stack:
        await installed.open(parts, stack)
    assert [alert.title for alert in installed.alerts()] == ["No bad"]
    with pytest.raises(KeyError):
        parts[Part]


def test_one_with_a_route_that_does_not_say_what_it_needs_keeps_the_app_from_being_made() -> None:
    def routes(_: Settings) -> list[APIRouter]:
        router = APIRouter(route_class=ApiRoute)
        router.get("/secrets")(test_each_has_a_page_and_tests)
        return [router]

    with pytest.raises(Undeclared):
        create_app(Settings(), installed=Installed([Extension("bad", routes=routes)]))


def test_a_route_that_is_there_already_keeps_the_app_from_being_made() -> None:
    def routes(_: Settings) -> list[APIRouter]:
        router = APIRouter(route_class=ApiRoute)
        router.get("/robots")(operation(Role.VIEWER, Scope.ANY)(test_each_has_a_page_and_tests))
        return [router]

    with pytest.raises(DuplicateRoute, match="two routes are GET /robots"):
        create_app(Settings(), installed=Installed([Extension("bad", routes=routes)]))


@pytest.mark.parametrize("field", ["heartbeat_interval", *extension_list.extension_settings()[0].model_fields])
def test_a_setting_that_is_there_already_keeps_the_gateway_from_starting(
    monkeypatch: pytest.MonkeyPatch, field: str
) -> None:
    kind = create_model("TakenSettings", __base__=ExtensionSettings, **{field: (str, "mine")})  # type: ignore[call-overload]
    found = SimpleNamespace(load=lambda: Extension("taken", settings=kind))
    monkeypatch.setenv("DOCK_GATEWAY_EXTENSIONS", "taken")
    monkeypatch.setattr(extension_list, "find_entry_point", lambda _: found)
    assert f"has a setting {field}," in (extension_list.missing_extension() or "")


def test_the_list_is_that_of_the_application(broken: str) -> None:
    installed = Installed([Extension("good", card=PAGE)], {broken: ImportError("no module")})
    parts = Parts({**audit_parts(), Settings: Settings(), Installed: installed})
    with TestClient(create_app(Settings(), parts), "http://127.0.0.1:8000") as http:
        assert http.get("/extensions").json() == {
            "extensions": [{"name": "good", "card": "/extensions/good/card.js"}, {"name": broken, "card": None}]
        }
        assert http.get("/extensions/good/card.js").status_code == 200
        assert http.get("/extensions/cameras/card.js").json()["code"] == "extension_not_found"


async def test_the_routes_of_one_that_failed_are_unavailable_and_no_others() -> None:
    router = APIRouter(route_class=ApiRoute)

    class Other:
        """A part that there should be: its module is none of the extension."""

    Other.__module__ = "dock_gateway.other"

    @router.get("/part")
    @operation(Role.VIEWER, Scope.ANY)
    async def get_part(part: RoutePart[Part]) -> Response:
        return Response(type(part).__name__)

    installed = Installed([Extension("bad", fails, routes=lambda _: [router])])
    parts = Parts({**audit_parts(), Settings: Settings(), Installed: installed})
    with TestClient(create_app(Settings(), parts), "http://127.0.0.1:8000") as http:
        async with AsyncExitStack() as stack:
            await installed.open(parts, stack)
        answer = http.get("/part")
        assert (answer.status_code, answer.json()["code"]) == (501, "extension_failed")
        assert answer.json()["detail"] == "bad could not be opened: see the alerts"
    with pytest.raises(KeyError):
        parts[Other]


def test_a_part_is_added_once() -> None:
    parts = Parts({})
    parts.add(Part, Part())
    with pytest.raises(ValueError, match="there is a Part already"):
        parts.add(Part, Part())


def test_settings_come_from_those_that_were_given_or_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    class Own(ExtensionSettings):
        number: int = 1

    both: Any = type("Both", (Own, Settings), {})
    assert both(number=2).of(Own).number == 2
    monkeypatch.setenv("DOCK_GATEWAY_NUMBER", "3")
    assert Settings().of(Own).number == 3
