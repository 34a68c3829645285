"""Shares of a database that several sites fill: what is too much is taken from the sites that have the most.

A goal is of the site that is the first part of its action's name: `/berlin/robot1/dock` is of `berlin`.
"""

from collections import Counter
from collections.abc import Iterable
from datetime import datetime
from typing import NamedTuple

import sqlalchemy as sa

from dock_gateway.storage.tables import IS_KEPT, events, goals


class Excess(NamedTuple):
    """The goals of a site that must go.

    Attributes:
        prefix: What the names of its actions begin with.
        last: When the newest of them was sent.
        running: Whether those that have not ended go, too, as there are no others.
    """

    prefix: str
    last: datetime
    running: bool

    @property
    def condition(self) -> sa.ColumnElement[bool]:
        """Selects the goals of the site."""
        return is_of(self.prefix)


def is_of(prefix: str) -> sa.ColumnElement[bool]:
    """Select the goals of a site."""
    # With the name that is the site alone. Not LIKE, which ignores case in SQLite.
    return sa.func.substr(goals.c.action_name + "/", 1, len(prefix)) == prefix


def sizes(connection: sa.Connection, overhead: int) -> Counter[str]:
    """Return the bytes that each site has, by its prefix.

    Args:
        connection: The database.
        overhead: Bytes of a row besides its text.
    """
    found = Counter[str]()
    of_events = sa.select(events.c.action_name, sa.func.sum(events.c.size), sa.func.count()).where(IS_KEPT)
    for name, size, count in connection.execute(of_events.group_by(events.c.action_name)):
        found[prefix_of(name or "/")] += size + overhead * count
    of_goals = sa.select(goals.c.action_name, sa.func.count()).group_by(goals.c.action_name)
    for name, count in connection.execute(of_goals):
        found[prefix_of(name)] += overhead * count
    return found


def prefix_of(action_name: str) -> str:
    """Return what the names of all actions of the same site begin with."""
    return f"/{action_name[1:].partition('/')[0]}/"


def share(sizes: Iterable[int], most: int) -> int:
    """Return how much each may have, so that together they have `most`: who has less leaves the rest to the others."""
    ordered = sorted(sizes)
    for number, size in enumerate(ordered):
        others = len(ordered) - number
        if size * others >= most:
            return most // others
        most -= size
    return ordered[-1] if ordered else 0
