"""The parts of the gateway, each found by its type: `Part[Labels]` as a parameter of a route, else `parts[Labels]`."""

from collections.abc import Callable, Coroutine, Mapping
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from fastapi import Depends
from starlette.requests import HTTPConnection

from dock_gateway.core.errors import NotInstalled

T = TypeVar("T")


class Parts:
    """The parts of one gateway.

    Args:
        parts: Each part by its type.
    """

    def __init__(self, parts: Mapping[type, Any]) -> None:
        self._parts = dict(parts)
        self._failed: dict[str, str] = {}

    def add(self, kind: type[T], part: T) -> T:
        """Add a part, and return it.

        Raises:
            ValueError: There is one of this type.
        """
        if kind in self._parts:
            raise ValueError(f"there is a {kind.__name__} already")
        self._parts[kind] = part
        return part

    def mark_failed(self, extension: str, package: str) -> None:
        """Say that the parts of an extension, whose types are in a package, are missing: it could not be opened."""
        self._failed[package] = extension

    def __getitem__(self, kind: type[T]) -> T:
        """Return a part.

        Raises:
            KeyError: There is none.
            NotInstalled: It is that of an extension that could not be opened (`extension_failed`).
        """
        try:
            part: T = self._parts[kind]
        except KeyError:
            for package, extension in self._failed.items():
                if f"{kind.__module__}.".startswith(f"{package}."):
                    detail = f"{extension} could not be opened: see the alerts"
                    raise NotInstalled(detail, code="extension_failed") from None
            raise
        return part


def parts_of(connection: HTTPConnection) -> Parts:
    """Return the parts of the gateway that a request was sent to."""
    parts: Parts = connection.state.parts
    return parts


async def depend_on_parts(connection: HTTPConnection) -> Parts:
    """Return all parts, for `Depends`. A coroutine: FastAPI runs each plain function in a thread, on every request."""
    return parts_of(connection)


AllParts = Annotated[Parts, Depends(depend_on_parts)]

if TYPE_CHECKING:
    Part = Annotated[T, "found by its type"]
else:

    class Part:
        """`Part[Labels]` is `Labels` to readers, and tells FastAPI to look that part up."""

        def __class_getitem__(cls, kind: type) -> Any:
            return Annotated[kind, Depends(_finder(kind))]


@cache  # the same dependency for the same type: FastAPI looks each up once in a request
def _finder(kind: type[T]) -> Callable[[HTTPConnection], Coroutine[Any, Any, T]]:
    async def find(connection: HTTPConnection) -> T:
        return parts_of(connection)[kind]

    return find
