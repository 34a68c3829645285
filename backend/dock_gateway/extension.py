"""An extension is a feature that can be taken out, with all that it adds to a gateway in one object.

`extension_list` names the extensions of a gateway, `dock_hub.extensions` those that a hub has, too. An extension
reaches the gateway by its parts, as a route does, and never imports another one.
"""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from fastapi import APIRouter
from prometheus_client import Metric
from pydantic import BaseModel

from dock_gateway.access.tool import Tool
from dock_gateway.core.error_codes import ErrorCode
from dock_gateway.core.event import utc_now
from dock_gateway.extension_list import OURS, PACKAGE, find_entry_point, further_names
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.goals.goal_documents import GoalDocuments, GoalField
from dock_gateway.http.operation import BadRoute
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Limit
from dock_gateway.settings import ExtensionSettings, Settings

log = logging.getLogger(__name__)

# Seconds that an extension may take to open, and to close.
OPEN_WITHIN, CLOSE_WITHIN = 30.0, 10.0

NO_FAILURE: Mapping[str, Exception] = {}


T = TypeVar("T")


@dataclass(frozen=True)
class Extension:
    """A feature.

    Attributes:
        name: Its name, which is that of its folder and of its page in docs/extensions.
        open: Opens its part until the gateway closes, given the parts that are open: `parts[RobotRegistry]`. Its routes
            find it by its type; None if it is switched off.
        settings: Its settings: options of the command line, variables of the environment.
        routes: Returns its routers: a function, so that what is off is not imported.
        events: The models of its events, which streams can ask for by their types with `include`.
        alerts: The kinds of alerts that it adds.
        errors: The error codes that it adds.
        limits: Returns what users share of it, by name.
        metrics: Returns the metrics of its part, also of None.
        tools: The tools that it adds for agents, where they are let in.
        goal_field: The field that it adds to the goals of the REST API.
        card: A file with an ES module that defines the custom element `NAME-card`, which a robot's page shows. For an
            extension of another distribution: ours are built into the dashboard.
    """

    name: str
    open: Callable[[Parts], AbstractAsyncContextManager[object]] | None = None
    settings: type[ExtensionSettings] | None = None
    routes: Callable[[Settings], Sequence[APIRouter]] = field(default=lambda _: ())
    events: Sequence[type[BaseModel]] = ()
    alerts: Sequence[AlertKind] = ()
    errors: Sequence[ErrorCode] = ()
    limits: Callable[[Settings], Mapping[str, Limit]] = field(default=lambda _: {})
    metrics: Callable[[Any], Iterable[Metric]] = field(default=lambda _: ())
    tools: Sequence[Tool] = ()
    goal_field: GoalField | None = None
    card: Path | None = None


class Installed:
    """The extensions of a gateway or a hub.

    Args:
        extensions: Those that could be imported.
        failed: Why each of the others could not, by name.

    Attributes:
        failed: An alert for each that could not be imported or opened, by name.
        metrics: What measures those that are open.
    """

    def __init__(self, extensions: Iterable[Extension], failed: Mapping[str, Exception] = NO_FAILURE) -> None:
        self._extensions = tuple(extensions)
        self.failed: dict[str, Alert] = {}
        self.metrics: list[Callable[[], Iterable[Metric]]] = []
        for name, error in failed.items():
            self._fail(name, error)

    @classmethod
    def load(cls, names: Iterable[str]) -> "Installed":
        """Import extensions.

        Raises:
            BadRoute: A route of one does not say which role it needs.
        """
        found: list[Extension] = []
        failed: dict[str, Exception] = {}
        for name in names:
            try:
                found.append(find_extension(name))
            except BadRoute:
                raise
            except Exception as error:  # noqa: BLE001 - logged by `_fail`
                failed[name] = error
        return cls(found, failed)

    def __iter__(self) -> Iterator[Extension]:
        return iter(self._extensions)

    @property
    def names(self) -> list[str]:
        """The names of all, also of those that failed."""
        return list(dict.fromkeys((*(each.name for each in self), *self.failed)))

    @property
    def events(self) -> tuple[type[BaseModel], ...]:
        """The models of their events."""
        return tuple(event for each in self for event in each.events)

    @property
    def goal_fields(self) -> dict[str, type[BaseModel]]:
        """The models of the fields that they add to goals, by name."""
        return {each.goal_field.name: each.goal_field.model for each in self if each.goal_field is not None}

    @property
    def kinds(self) -> list[AlertKind]:
        """The kinds of alerts that they add."""
        return [kind for each in self for kind in each.alerts]

    @property
    def errors(self) -> list[ErrorCode]:
        """The error codes that they add."""
        return [code for each in self for code in each.errors]

    @property
    def tools(self) -> list[Tool]:
        """The tools that they add for agents, of those that are open."""
        return [tool for each in self if each.name not in self.failed for tool in each.tools]

    def limits(self, settings: Settings) -> dict[str, Limit]:
        """Return what users share of them, by name."""
        return {name: limit for each in self for name, limit in each.limits(settings).items()}

    def routers(self, settings: Settings) -> list[APIRouter]:
        """Return their routers, without those that cannot be imported.

        Raises:
            BadRoute: A route does not say which role it needs.
        """
        routers: list[APIRouter] = []
        for each in self:
            try:
                routers += each.routes(settings)
            except BadRoute:
                raise
            except Exception as error:  # noqa: BLE001 - logged by `_fail`
                self._fail(each.name, error)
        return routers

    async def open(self, parts: Parts, stack: AsyncExitStack) -> None:
        """Open them, in order, and register them with the stack for closing. One that fails is left out.

        Args:
            parts: What they reach, and where the part of each is added.
            stack: Closes them.
        """
        for name in self.goal_fields:
            parts[GoalDocuments].fields[name] = None
        for each in self:
            if each.open is None or each.name in self.failed:
                continue
            try:
                async with AsyncExitStack() as opened:
                    part = await opened.enter_async_context(_within_deadlines(each.name, each.open(parts)))
                    if part is not None:
                        parts.add(type(part), part)
                    stack.push_async_exit(opened.pop_all())
            except Exception as error:  # noqa: BLE001 - logged by `_fail`
                self._fail(each.name, error)
                parts.mark_failed(each.name, each.open.__module__.rpartition(".")[0] or each.open.__module__)
            else:
                self.metrics.append(partial(each.metrics, part))
                if each.goal_field is not None and part is not None:
                    parts[GoalDocuments].fields[each.goal_field.name] = partial(each.goal_field.read, part)

    def alerts(self) -> list[Alert]:
        """Return an alert for each that could not be imported or opened."""
        return list(self.failed.values())

    def _fail(self, name: str, error: Exception) -> None:
        log.error("the extension %s could not be opened", name, exc_info=error)
        detail = f"{name} could not be opened, and is missing until the gateway starts again: {error}"
        self.failed.setdefault(name, Alert(alert_kinds.EXTENSION_FAILED, None, utc_now(), f"No {name}", detail))


@asynccontextmanager
async def _within_deadlines(name: str, opening: AbstractAsyncContextManager[T]) -> AsyncIterator[T]:
    async with AsyncExitStack() as stack:
        try:
            async with asyncio.timeout(OPEN_WITHIN):
                part = await stack.enter_async_context(opening)
        except TimeoutError:
            raise TimeoutError(f"it was not open within {OPEN_WITHIN:g} s") from None
        try:
            yield part
        finally:
            try:
                async with asyncio.timeout(CLOSE_WITHIN):
                    await stack.aclose()
            except TimeoutError:
                log.exception("the extension %s was not closed within %g s", name, CLOSE_WITHIN)


def extensions() -> Installed:
    """Import the extensions of a gateway: ours, and those that `DOCK_GATEWAY_EXTENSIONS` names."""
    return Installed.load((*OURS, *further_names()))


def find_extension(name: str) -> Extension:
    """Return an extension of ours, or of another distribution.

    Raises:
        TypeError: There is none of this name.
    """
    if name in OURS:
        extension = import_module(f"{PACKAGE}.{name}.extension").extension
    else:
        found = find_entry_point(name)
        extension = None if found is None else found.load()
    if not isinstance(extension, Extension) or extension.name != name:
        raise TypeError(f"there is no extension {name}")
    return extension
