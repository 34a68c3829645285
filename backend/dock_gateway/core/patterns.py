"""Patterns of names on the ROS graph, in which `*` stands for any text."""

import re
from collections.abc import Iterable


def expression(pattern: str) -> str:
    """Return an expression for a pattern.

    The first place of each part between two `*` is the only one that is tried. That finds every match, and the time
    grows with the length of a name, not with its square.
    """
    first, *others = map(re.escape, pattern.split("*"))
    if not others:
        return first
    *middle, last = others
    return first + "".join(f"(?>.*?{part})" for part in middle) + f".*{last}"


def match_any(expressions: Iterable[str]) -> re.Pattern[str]:
    """Return an expression that matches what any of them does; everything if there is none."""
    return re.compile("|".join(expressions) or ".*", re.DOTALL)


def match_namespaces(patterns: Iterable[str]) -> re.Pattern[str]:
    """Return an expression that matches the names in namespaces; every name if there are no patterns.

    Args:
        patterns: Patterns of namespaces. Each includes those below it, but `/` is only what has no namespace.
    """
    above = (each.rstrip("/") for each in patterns)
    return match_any(expression(f"{each}/*") if each else "/[^/]+" for each in above)


def overlap(one: str, other: str) -> bool:
    """Return whether two patterns of namespaces can include the same namespace."""
    if "/" in (one, other):
        return one == other
    first, second = f"{one}/*", f"{other}/*"
    ends, seen, todo = (len(first), len(second)), set[tuple[int, int]](), [(0, 0)]
    while todo:
        place = i, j = todo.pop()
        if place == ends:
            return True
        if place in seen or i > ends[0] or j > ends[1]:
            continue
        seen.add(place)
        left, right = first[i : i + 1], second[j : j + 1]
        if "*" in (left, right):  # it ends here, or stands for the next character of the other
            todo += [(i + 1, j), (i, j + 1)]
        elif left == right:
            todo.append((i + 1, j + 1))
    return False
