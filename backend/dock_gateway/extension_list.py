"""The one list of extensions: no other module of the gateway names them.

A command that only reads settings imports no more than those: an extension takes its time to import. Besides ours there
are those of other distributions, which `DOCK_GATEWAY_EXTENSIONS` names and an entry point of theirs leads to.
"""

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from typing import TypeVar

from dock_gateway.setting_groups.group import PREFIX
from dock_gateway.settings import ExtensionSettings, Settings

S = TypeVar("S", bound=Settings)

OURS = (
    "audit_log",
    "recordings",
    "statistics",
    "maps",
    "cameras",
    "automation",
    "chargers",
    "missions",
    "webhooks",
    "rosbridge",
    "foxglove",
    "agents",
    "single_sign_on",
    "traces",
    "sites",
    "simulator",
)
PACKAGE = "dock_gateway.extensions"
# The group of the entry points of other distributions.
GROUP = "dock_gateway.extensions"


def further_names() -> tuple[str, ...]:
    """Return the names of the extensions of other distributions that are wanted."""
    names = (name.strip() for name in os.environ.get(f"{PREFIX}EXTENSIONS", "").split(","))
    return tuple(dict.fromkeys(name for name in names if name))


def find_entry_point(name: str) -> EntryPoint | None:
    """Return the entry point of an extension of another distribution; None if no distribution has it."""
    return next(iter(entry_points(group=GROUP, name=name)), None)


def modules_of(kind: str, names: Iterable[str] = OURS) -> Iterator[str]:
    """Yield the modules of one name, such as `settings`, that extensions of ours have."""
    for name in names:
        with suppress(Exception):  # as an extension that cannot be imported has none
            if find_spec(module := f"{PACKAGE}.{name}.{kind}") is not None:
                yield module


def missing_extension() -> str | None:
    """Return a sentence about an extension that is wanted and cannot be loaded; None if there is none."""
    for name in further_names():
        if name in OURS:
            return f"extensions: {name} is one of the gateway's own, which are always there"
        if find_entry_point(name) is None:
            return f"extensions: no installed distribution has an extension {name} (entry points of {GROUP})"
    return _setting_declared_twice()


def _setting_declared_twice() -> str | None:
    taken = set(Settings.model_fields).union(*(kind.model_fields for kind in ours_with_settings()))
    for kind in _further():
        if clash := sorted(taken & kind.model_fields.keys()):
            return (
                f"extensions: {kind.__module__} has a setting {clash[0]}, and so has the gateway or another extension"
            )
        taken |= kind.model_fields.keys()
    return None


@cache
def extension_settings() -> tuple[type[ExtensionSettings], ...]:
    """Return the settings of the extensions of a gateway."""
    return (*ours_with_settings(), *_further())


@cache
def settings_type() -> type[Settings]:
    """Return the settings of a gateway with those of its extensions."""
    return with_extensions("GatewaySettings", Settings, extension_settings())


def with_extensions(name: str, base: type[S], added: Iterable[type[ExtensionSettings]]) -> type[S]:
    """Return settings that have those of extensions, too."""
    return type(name, (*added, base), {"__doc__": base.__doc__})


def ours_with_settings(names: Iterable[str] = OURS) -> Iterator[type[ExtensionSettings]]:
    """Yield the settings of extensions of ours."""
    for name in modules_of("settings", names):
        with suppress(Exception):  # the alert `extension_failed` says why, once the gateway runs
            yield from filter(_is_settings, vars(import_module(name)).values())


def _further() -> Iterator[type[ExtensionSettings]]:
    for name in further_names():
        with suppress(Exception):  # the alert `extension_failed` says why, once the gateway runs
            if (found := find_entry_point(name)) is not None and (settings := found.load().settings) is not None:
                yield settings


def _is_settings(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, ExtensionSettings) and kind is not ExtensionSettings
