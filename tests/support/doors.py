"""The doors of extensions, for tests of what holds at every door: `DOORS` in `tests/extensions/NAME/door.py`."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.support.gateway import RunningGateway

EXTENSIONS = Path(__file__).parents[1] / "extensions"

# A connection that sends no pings: their payloads are drawn from `random`, which Hypothesis allows no one beside it.
QUIET: dict[str, Any] = {"ping_interval": None}

# Asks for a stop with these fields; returns its report.
Stop = Callable[[Any], dict[str, Any]]
Headers = Mapping[str, str]


@dataclass(frozen=True)
class Door:
    """One way to the gateway that an extension adds.

    Attributes:
        name: Its name, in the report of a test that fails.
        stop: Opens a connection on which stops are asked for.
        topics: Returns the topics that a login is offered, as soon as one of them is there; None if it offers none.
        reads: Returns whether a login may subscribe to a topic; None where only what is offered can be subscribed to.
        settings: Settings of a gateway that has it.
    """

    name: str
    stop: Callable[[RunningGateway], AbstractContextManager[Stop]]
    topics: Callable[[RunningGateway, Headers, str], set[str]] | None = None
    reads: Callable[[RunningGateway, Headers, str], bool] | None = None
    settings: Mapping[str, str] = field(default_factory=dict)


def doors() -> list[Door]:
    """Return the doors of the extensions that are there."""
    names = sorted(path.parent.name for path in EXTENSIONS.glob("*/door.py"))
    found: Sequence[Sequence[Door]] = [import_module(f"tests.extensions.{name}.door").DOORS for name in names]
    return [door for of_extension in found for door in of_extension]
