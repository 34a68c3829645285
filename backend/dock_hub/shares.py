"""Shares of a database that several sites fill: what is too much is taken from the sites that have the most.

A goal is of the site that is the first part of its action's name: `/berlin/robot1/dock` is of `berlin`.
"""

from collections import Counter
from collections.abc import Iterable
from datetime import datetime
from typing import NamedTuple

import sqlalchemy as sa

from dock_gateway.storage.retention import (
    HAS_ENDED,
    MOST_GOALS,
    OVERHEAD,
    Deleted,
    ExcessRule,
    delete_goals,
    last_beyond,
)
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


def sizes_of_sites(connection: sa.Connection) -> Counter[str]:
    """Return the bytes that each site has, by its prefix."""
    found = Counter[str]()
    of_events = sa.select(events.c.action_name, sa.func.sum(events.c.size), sa.func.count()).where(IS_KEPT)
    for name, size, count in connection.execute(of_events.group_by(events.c.action_name)):
        found[prefix_of(name or "/")] += size + OVERHEAD * count
    of_goals = sa.select(goals.c.action_name, sa.func.count()).group_by(goals.c.action_name)
    for name, count in connection.execute(of_goals):
        found[prefix_of(name)] += OVERHEAD * count
    return found


def prefix_of(action_name: str) -> str:
    """Return what the names of all actions of the same site begin with."""
    return f"/{action_name[1:].partition('/')[0]}/"


def fair_share(sizes: Iterable[int], most: int) -> int:
    """Return how much each may have, so that together they have `most`: who has less leaves the rest to the others."""
    ordered = sorted(sizes)
    for number, size in enumerate(ordered):
        others = len(ordered) - number
        if size * others >= most:
            return most // others
        most -= size
    return ordered[-1] if ordered else 0


def find_excess(most: int, connection: sa.Connection) -> Excess | None:
    """Return which goals must go of the site that has the most; None if no site has more than its share."""
    sizes = sizes_of_sites(connection)
    if sizes.total() <= most:
        return None
    prefix, size = sizes.most_common(1)[0]
    total = sa.select(sa.literal(size, sa.BigInteger))
    events_of_goal = sa.select(sa.func.sum(events.c.size) + OVERHEAD * sa.func.count()).where(
        IS_KEPT, events.c.goal_id == goals.c.goal_id
    )
    size_of_goal = sa.func.coalesce(events_of_goal.scalar_subquery(), 0) + OVERHEAD
    for running in (False, True):
        ended = () if running else (HAS_ENDED,)
        oldest = sa.select(goals.c.created_at, size_of_goal).where(is_of(prefix), *ended)
        oldest = oldest.order_by(goals.c.created_at).limit(MOST_GOALS)
        last = last_beyond(connection, fair_share(sizes.values(), most), total, oldest)
        if last is not None:
            return Excess(prefix, last, running)
    return None


def delete_excess(connection: sa.Connection, excess: Excess) -> Deleted:
    """Delete some of the goals that must go."""
    among = (excess.condition,) if excess.running else (excess.condition, HAS_ENDED)
    return delete_goals(connection, excess.last, among=among)


# None of the sites takes the place of another.
BY_SITE = ExcessRule(find_excess, delete_excess)
