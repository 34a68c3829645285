"""An extension that fails halfway, or is closed, leaves nothing behind, and goals are sent as before."""

import gc
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, asynccontextmanager
from pathlib import Path

import pytest

from dock_gateway.assembly import open_gateway
from dock_gateway.core.access import ANYBODY
from dock_gateway.core.listeners import Hooks
from dock_gateway.extension import Extension, Installed, extensions
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.further_ways import FurtherWays
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings
from tests.support.gateway import running_program
from tests.support.waiting import until

pytestmark = pytest.mark.ros

OURS = "dock_gateway.extensions."


@pytest.fixture
def settings(domain: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Settings]:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    with running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.01"):
        yield Settings(
            database_url=f"sqlite:///{tmp_path}/history.db", stop_path=tmp_path / "stops.json", server_wait=30
        )


def refuse(*_: object) -> None:
    """What a broken extension adds everywhere."""
    raise ZeroDivisionError


class Watch:
    """What is added to all that anything can be added to in this process, wherever it is."""

    def __init__(self) -> None:
        self._others = self._all()  # of other tests
        self.before: dict[Hooks[object], list[object]] = {}
        self.after: dict[Hooks[object], list[object]] = {}
        self.left: list[object] = []

    @staticmethod
    def _all() -> list[Hooks[object]]:
        return [each for each in gc.get_objects() if issubclass(type(each), Hooks)]  # `isinstance` asks dead proxies

    def hooks(self) -> list[Hooks[object]]:
        """Return those of the gateway of this test."""
        others = {id(each) for each in self._others}
        return [each for each in self._all() if id(each) not in others]

    def added(self) -> dict[Hooks[object], list[object]]:
        return {each: list(each) for each in self.hooks()}

    def of_extensions(self) -> list[object]:
        return [item for each in self.hooks() for item in each if getattr(item, "__module__", "").startswith(OURS)]

    @asynccontextmanager
    async def open_first(self, _: Parts) -> AsyncIterator[None]:
        """Open before all others, and close after them."""
        self.before = self.added()
        yield
        self.left = self.of_extensions()

    @asynccontextmanager
    async def open_broken(self, parts: Parts) -> AsyncIterator[None]:
        with ExitStack() as stack:
            for hooks in self.hooks():
                stack.enter_context(hooks.adding(refuse))
            assert refuse in parts[ActionRegistry].before_send
            assert refuse in parts[AlertBoard].sources
            assert refuse in parts[FurtherWays]
            raise OSError("half-way")
            yield

    @asynccontextmanager
    async def open_next(self, _: Parts) -> AsyncIterator[None]:
        self.after = self.added()
        yield


async def test_what_it_has_added_is_gone(settings: Settings) -> None:
    watch = Watch()
    own = (watch.open_first, watch.open_broken, watch.open_next)
    installed = Installed([*(Extension(f"own{number}", each) for number, each in enumerate(own)), *extensions()])
    async with open_gateway(settings, installed) as parts:
        (alert,) = installed.alerts()
        assert (alert.kind, "half-way" in alert.detail) == (alert_kinds.EXTENSION_FAILED, True)
        assert len(watch.before) > 10
        assert watch.after == watch.before
        assert len(watch.of_extensions()) > 10
        action = await parts[ActionRegistry].find("/fibonacci")
        goal = await action.delivery.start(action.port.goal_codec.parse({"order": 1}), sender=ANYBODY)
        await until(lambda: goal.status.final)
        assert goal.status == "succeeded"
    assert watch.left == []
