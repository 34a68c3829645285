"""What `?include=` can name: types of events, and groups of them."""

from collections.abc import Iterable
from typing import get_args

from pydantic import BaseModel

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.streams.schema import EVENTS, GOAL_EVENTS, FleetEvent, SystemEvent

GROUPS: dict[str, type[BaseModel]] = {"system": SystemEvent, "fleet": FleetEvent}


def type_of(model: type[BaseModel]) -> str:
    """Return the `type` of the events of a model."""
    (name,) = get_args(model.model_fields["type"].annotation)
    return str(name)


class Includes:
    """The names that streams accept in `include`.

    Args:
        further: The models of events that are not the core's.
        also: Further types that are accepted, and of which there are no events.

    Attributes:
        names: All of them: types of events, then groups.
    """

    def __init__(self, further: Iterable[type[BaseModel]] = (), *, also: Iterable[str] = ()) -> None:
        always = {type_of(model) for model in GOAL_EVENTS}
        models = [model for model in (*EVENTS, *further) if type_of(model) not in always]
        self._types = {name: frozenset({name}) for name in (*map(type_of, models), *also)}
        for group, base in GROUPS.items():
            self._types[group] = frozenset(type_of(model) for model in models if issubclass(model, base))
        self.names = tuple(self._types)

    def read(self, text: str) -> frozenset[str]:
        """Return the types of events that names with commas between them stand for.

        Raises:
            InvalidField: One is not known.
        """
        names = [name for each in text.split(",") if (name := each.strip())]
        if unknown := [name for name in names if name not in self._types]:
            expected = f"any of {', '.join(self.names)}"
            raise InvalidField([FieldError("include", expected, f"got {unknown[0][:60]!r}", "query")])
        return frozenset().union(*(self._types[name] for name in names))
