"""The templates of all gateways that share the history."""

import logging
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.versions import UNCONDITIONAL, Condition
from dock_gateway.extensions.missions.battery import BatteryLimits
from dock_gateway.extensions.missions.step import StepFields
from dock_gateway.extensions.missions.templates.parameters import Filling, at_arguments, read_steps, require_arguments
from dock_gateway.extensions.missions.templates.template import TemplateEntry
from dock_gateway.storage.shared_entries import SharedBook

log = logging.getLogger(__name__)

MAX_TEMPLATES = 200
# Where a step has the name of an action, a service or a topic.
NAMES = {"action": "name", "call": "service", "publish": "topic"}


class Filled(NamedTuple):
    """What a mission is made of.

    Attributes:
        steps: Its steps.
        name: Its name, if the request has none.
        priority: Its priority, if the request has none.
        places: Where in the steps which argument of the request stands.
        battery: When the robot returns to charge, if the request does not say so.
    """

    steps: list[StepFields]
    name: str | None
    priority: int
    places: Mapping[str, str]
    battery: BatteryLimits | None = None


class Templates:
    """The templates.

    Args:
        book: Stores them.
    """

    def __init__(self, book: SharedBook[TemplateEntry]) -> None:
        self._book = book

    async def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the templates as `GET /mission-templates` shows them, by id: those all of whose names are covered.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        found = (await self._book.read()).items()
        return [self._document(key, template) for key, template in sorted(found) if _covers(template, grant)]

    async def document(self, template_id: str, grant: Grant = UNLIMITED) -> dict[str, Any]:
        """Return a template as `GET /mission-templates/{template_id}` shows it.

        Raises:
            NotFound: There is none, or the grant does not cover it (`template_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return self._document(template_id, await self._find(template_id, grant))

    async def replace(
        self, template_id: str, template: TemplateEntry, condition: Condition = UNCONDITIONAL
    ) -> tuple[dict[str, Any], bool]:
        """Store a template, new or changed; return it, and whether it is new.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            Conflict: `limit_reached`.
            Unavailable: The history does not answer (`history_unavailable`); the template is what it was.
        """
        new = await self._book.replace(template_id, template, condition=condition)
        log.info("template %s of missions: %d steps, by %s", template_id, len(template.steps), template.changed_by)
        return self._document(template_id, template), new

    async def remove(self, template_id: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove a template.

        Raises:
            ChangedMeanwhile: It has not the version of the condition.
            NotFound: `template_not_found`.
            Unavailable: The history does not answer (`history_unavailable`); the template is still there.
        """
        await self._book.remove(template_id, condition)
        log.info("template %s of missions removed", template_id)

    async def fill(self, template_id: str, arguments: Mapping[str, Any], grant: Grant) -> Filled:
        """Return what a mission of a template is made of.

        Raises:
            InvalidField: An argument is missing or not known, or the steps are none with them; with the path.
            NotFound: There is none, or the grant does not cover it (`template_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        template = await self._find(template_id, grant)
        filling = Filling(require_arguments(arguments, template.defaults))
        steps = filling.fill(template.steps, "steps")
        given = {path: name for path, name in filling.places.items() if name in arguments}
        with at_arguments(given):
            return Filled(read_steps(steps), template.name, template.priority, given, template.battery)

    async def _find(self, template_id: str, grant: Grant) -> TemplateEntry:
        template = await self._book.find(template_id)
        if not _covers(template, grant):
            raise self._book.missing(template_id)
        return template

    def _document(self, template_id: str, template: TemplateEntry) -> dict[str, Any]:
        return {"id": template_id, "etag": self._book.etag(template), **template.model_dump()}


def _covers(template: TemplateEntry, grant: Grant) -> bool:
    """Return whether a grant covers the actions, services and topics that a template names."""
    covers = {"action": grant.covers_action, "call": grant.covers_service, "publish": grant.covers_publishing}
    return not grant.limited or all(covers[kind](name) for kind, name in _names(template.steps))


def _names(value: Any) -> Iterator[tuple[str, str]]:
    """Yield the names in steps, each with the kind of its step; one that is a parameter is not known yet."""
    if isinstance(value, list):
        for item in value:
            yield from _names(item)
    elif isinstance(value, dict):
        for kind, item in value.items():
            named = item.get(NAMES[kind]) if kind in NAMES and isinstance(item, dict) else None
            if isinstance(named, str) and not named.startswith("$"):
                yield kind, named
            yield from _names(item)
