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
