"""What an object keeps, however deep: for tests that want to see that nothing is left behind."""

import gc
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any, TypeVar

Kept = TypeVar("Kept")


def reachable(root: object, kind: type[Kept]) -> list[Kept]:
    """Return all objects of a kind that an object refers to, directly or through others; not through what code names.

    Args:
        root: The object.
        kind: A class.
    """
    seen: set[int] = {id(root)}
    waiting: list[Any] = [root]
    found: list[Kept] = []
    while waiting:
        for each in gc.get_referents(waiting.pop()):
            if isinstance(each, FunctionType):
                parts = list(each.__closure__ or ())
            elif isinstance(each, type | ModuleType | BuiltinFunctionType):
                continue
            else:
                parts = [each]
            for part in parts:
                if id(part) in seen:
                    continue
                seen.add(id(part))
                waiting.append(part)
                if isinstance(part, kind):
                    found.append(part)
    return found
