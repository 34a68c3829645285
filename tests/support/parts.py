"""The parts of a gateway that has only some of them."""

from typing import Any

from dock_gateway.core.errors import NotFound
from dock_gateway.http.parts import Parts, T


class Refusing(Parts):
    """Parts of which most are missing: whoever asks for one of those was let through."""

    def __getitem__(self, kind: type[T]) -> T:
        try:
            return super().__getitem__(kind)
        except KeyError:
            raise NotFound(f"there is no {kind.__name__}") from None


class FakeParts(Parts):
    """Parts, each of which can be replaced."""

    def replace(self, kind: type, part: Any) -> None:
        """Have another part of a type."""
        self._parts[kind] = part
