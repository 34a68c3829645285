"""Names on the ROS graph that a client gives: hints at similar ones, and the types among which it may choose."""

import difflib
import heapq
from collections.abc import Iterable, Sequence

from dock_gateway.core.errors import FieldError, InvalidField, NotFound, NotInstalled

# Similar names in a hint.
MAX_HINTS = 3
# Names that are compared for a hint: those that begin and end most like it. A stop would have to wait for a comparison
# with all those of a fleet.
MAX_COMPARED = 20


def not_found(kind: str, name: str, known: Iterable[str]) -> NotFound:
    """Return the error that a service, a topic or a node is not on the graph, with the most similar of those known."""
    near = heapq.nlargest(MAX_COMPARED, known, key=lambda each: _ends_alike(name, each))
    similar = difflib.get_close_matches(name, near, n=MAX_HINTS, cutoff=0.6)
    hint = f"; did you mean {' or '.join(similar)}?" if similar else ""
    return NotFound(f"there is no {kind} {name[:200]} on the ROS graph{hint}", code=f"{kind}_not_found")


def _ends_alike(name: str, other: str) -> int:
    """Return how many characters two names have in common at their beginnings and ends."""
    return sum(_same_first(*pair) for pair in ((name, other), (name[::-1], other[::-1])))


def _same_first(name: str, other: str) -> int:
    return next((at for at, (one, two) in enumerate(zip(name, other, strict=False)) if one != two), len(name))


def choose_type(name: str, types: Sequence[str], wanted: str | None) -> str:
    """Return the type to use of those that a name has on the graph.

    Raises:
        InvalidField: The wanted one is none of them, or none is wanted and there are several.
    """
    expected = f"one of {', '.join(types)}"
    if wanted is not None and wanted not in types:
        raise InvalidField([FieldError("type", expected, f"got {wanted[:100]!r}", "query")])
    if wanted is None and len(types) > 1:
        raise InvalidField([FieldError("type", expected, f"{name} has several types on the ROS graph", "query")])
    return wanted or types[0]


def not_installed(name: str, type_name: str, why: object) -> NotInstalled:
    """Return the error that messages of a type cannot be read or written."""
    return NotInstalled(f"{name} is of type {type_name}: {why}")
