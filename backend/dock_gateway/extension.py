"""What an extension is: a feature that can be taken out, with all that it adds to a gateway in one object.

`extension_list` names the extensions; nothing else does. An extension reaches the gateway by its core, and never
imports another one.
"""

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from dataclasses import dataclass, field
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from fastapi import APIRouter
from prometheus_client import Metric
from pydantic import BaseModel

from dock_gateway.core.alerts import Alerts
from dock_gateway.core.event import utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.extension_list import OURS, PACKAGE, find_entry_point, further_names
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.alert import Alert
from dock_gateway.fleet.alert_kinds import AlertKind
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Limit
from dock_gateway.observability.collector import Further
from dock_gateway.settings import ExtensionSettings, Settings
from dock_gateway.storage import History

if TYPE_CHECKING:  # an extension that a hub has, too, needs no ROS
    from dock_gateway.fleet.alerts import AlertBoard
    from dock_gateway.goals.registry import ActionRegistry
    from dock_gateway.graph.cache import GraphCache
    from dock_gateway.graph.relays import Relays
    from dock_gateway.robots.registry import RobotRegistry
    from dock_gateway.stop.stopper import Stopper

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Core:
    """What an extension may reach of an open gateway or hub.

    Attributes:
        settings: The settings; `settings.of` has those of the extension.
        history: Goals, events and documents that last.
        events: Publishes events to streams.
        alerts: The active alerts.
        parts: All parts, by their types.
    """

    settings: Settings
    history: History
    events: Fanout
    alerts: Alerts
    parts: Parts


@dataclass(frozen=True)
class GatewayCore(Core):
    """What an extension may reach of an open gateway, besides what a hub has.

    Attributes:
        alerts: An extension adds a source of its own.
        robots: The robots; says what is on the ROS graph, and which robot is about to be removed.
        goals: The actions and their goals; says when one is sent, changes, ends or is lost.
        graph: What is on the ROS graph.
        topics: Reads topics, one subscription for all readers.
        stop: Stops robots; says when one is stopped.
    """

    alerts: "AlertBoard"
    robots: "RobotRegistry"
    goals: "ActionRegistry"
    graph: "GraphCache"
    topics: "Relays"
    stop: "Stopper"


Core_contra = TypeVar("Core_contra", bound=Core, contravariant=True)
C = TypeVar("C", bound=Core)


@dataclass(frozen=True)
class Extension(Generic[Core_contra]):
    """A feature.

    Attributes:
        name: Its name, which is that of its folder and of its page in docs/extensions.
        open: Opens its part, which its routes find by its type, until the gateway closes; None if it is switched off.
        settings: Its settings: options of the command line, variables of the environment.
        routes: Returns its routers: a function, so that what is off is not imported.
        includes: Topics of events that streams can ask for with `include`.
        events: The models of these events.
        alerts: The kinds of alerts that it adds.
        limits: Returns what users share of it, by name.
        metrics: Returns the metrics of its part.
        card: A file with an ES module that defines the custom element `NAME-card`, which a robot's page shows. For an
            extension of another distribution: ours are built into the dashboard.
    """

    name: str
    open: Callable[[Core_contra], AbstractAsyncContextManager[object]] | None = None
    settings: type[ExtensionSettings] | None = None
    routes: Callable[[Settings], Sequence[APIRouter]] = field(default=lambda _: ())
    includes: Sequence[str] = ()
    events: Sequence[type[BaseModel]] = ()
    alerts: Sequence[AlertKind] = ()
    limits: Callable[[Settings], Mapping[str, Limit]] = field(default=lambda _: {})
    metrics: Callable[[Any], Iterable[Metric]] = field(default=lambda _: ())
    card: Path | None = None


@dataclass(frozen=True)
class Opened:
    """The extensions that are open: what measures them, and an alert for each that could not be opened."""

    metrics: Further
    failed: Sequence[Alert]


@cache
def extensions() -> tuple[Extension[GatewayCore], ...]:
    """Return the extensions of a gateway: ours, and those that `DOCK_GATEWAY_EXTENSIONS` names."""
    return tuple(map(find_extension, (*OURS, *further_names())))


def find_extension(name: str) -> Extension[Any]:
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


def events() -> tuple[type[BaseModel], ...]:
    """Return the models of the events of all extensions."""
    return tuple(event for extension in extensions() for event in extension.events)


async def open_extensions(installed: Iterable[Extension[C]], core: C, stack: AsyncExitStack) -> Opened:
    """Open extensions, in order, and register them with the stack for closing. One that fails is left out."""
    metrics: list[Callable[[], Iterable[Metric]]] = []
    failed: list[Alert] = []
    for extension in installed:
        if extension.open is None:
            continue
        try:
            part = await stack.enter_async_context(extension.open(core))
        except Exception as error:
            log.exception("the extension %s could not be opened", extension.name)
            failed.append(_failure(extension.name, error))
        else:
            if part is not None:
                core.parts.add(type(part), part)
                metrics.append(partial(extension.metrics, part))
    return Opened(metrics, failed)


def _failure(name: str, error: Exception) -> Alert:
    detail = f"{name} could not be opened, and is missing until the gateway starts again: {error}"
    return Alert(alert_kinds.EXTENSION_FAILED, None, utc_now(), f"No {name}", detail)
