"""How much is held in memory: the length of each container that objects of the gateway hold, wherever it is."""

from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any


def sizes(root: object) -> Counter[str]:
    """The lengths by where the containers are, such as `Action.tracker.live`; those of the same place are added up."""
    found: Counter[str] = Counter()
    seen: set[int] = set()
    todo: deque[tuple[str, Any]] = deque([(type(root).__name__, root)])
    while todo:
        path, value = todo.popleft()
        if id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, Mapping | AbstractSet | list | deque):
            found[path] += len(value)
            # A copy: other threads may change it meanwhile.
            items = list(value.values() if isinstance(value, Mapping) else value)
            todo.extend((f"{path}[]", each) for each in items)
        elif type(value).__module__.startswith("dock_gateway"):
            todo.extend((f"{path}.{name}", each) for name, each in _attributes(value))
    return found


def _attributes(value: object) -> Iterator[tuple[str, Any]]:
    yield from vars(value).copy().items() if hasattr(value, "__dict__") else ()
    slots: Iterable[str] = getattr(type(value), "__slots__", ())
    yield from ((name, getattr(value, name)) for name in slots if hasattr(value, name) and name != "__dict__")
