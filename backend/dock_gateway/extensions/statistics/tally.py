"""Counts ends of goals: success rate, durations and error codes.

One query reads the goals once and returns a row for each action, status and error code, with the durations of all its
goals in one text. So little is transferred, and goals can be put into any groups afterwards, with exact percentiles.
"""

import asyncio
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any

import numpy as np
import numpy.typing as npt
import sqlalchemy as sa

from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage import History
from dock_gateway.storage.queries import conditions
from dock_gateway.storage.tables import goals

# From `since` up to but not including `until`.
Span = tuple[datetime, datetime]
Durations = npt.NDArray[np.float64]

PIECE = 100_000  # characters


@dataclass
class Tally:
    """The goals of a group that have ended.

    Attributes:
        statuses: How many ended in each state.
        errors: How many have each error code.
        retries: The sum of the retries that servers reported.
        reported: The number of goals with reported retries.
        durations: Milliseconds that each succeeded goal took, in several pieces.
    """

    statuses: Counter[GoalStatus] = field(default_factory=Counter)
    errors: Counter[str] = field(default_factory=Counter)
    retries: int = 0
    reported: int = 0
    durations: list[Durations] = field(default_factory=list)

    def add(self, other: "Tally") -> None:
        """Add the goals of another tally."""
        self.statuses.update(other.statuses)
        self.errors.update(other.errors)
        self.retries += other.retries
        self.reported += other.reported
        self.durations += other.durations

    @property
    def ended(self) -> int:
        """The number of goals."""
        return self.statuses.total()

    @property
    def success_rate(self) -> float | None:
        """The share of succeeded goals among those that were not canceled; None if there are none."""
        counted = self.ended - self.statuses[GoalStatus.CANCELED]
        return self.statuses[GoalStatus.SUCCEEDED] / counted if counted else None

    @property
    def mean_retries(self) -> float | None:
        """The mean number of retries, where it was reported."""
        return self.retries / self.reported if self.reported else None

    def percentiles(self, *percents: float) -> list[float | None]:
        """Return percentiles of the durations of the succeeded goals, in seconds, interpolated between goals."""
        if not any(piece.size for piece in self.durations):
            return [None] * len(percents)
        return [float(each) / 1000 for each in np.percentile(np.concatenate(self.durations), percents)]


# A tally for each action name, or one for all with an empty name.
Tallies = dict[str, Tally]


def merged(tallies: Iterable[Tally]) -> Tally:
    """Return the sum of tallies."""
    total = Tally()
    for tally in tallies:
        total.add(tally)
    return total


def read_rows(
    connection: sa.Connection, wanted: GoalFilter, spans: Sequence[Span], by_action: bool
) -> "list[Sequence[sa.Row[Any]]]":
    """Return the rows for `tally_rows`, for each span."""
    took = sa.case((goals.c.status == GoalStatus.SUCCEEDED.value, sa.cast(_milliseconds(connection), sa.Text)))
    name = goals.c.action_name if by_action else sa.literal_column("''")
    columns = name, goals.c.status, goals.c.error_code
    retries = goals.c.retries
    query = sa.select(
        *columns, sa.func.count(), sa.func.sum(retries), sa.func.count(retries), sa.func.aggregate_strings(took, ",")
    ).group_by(*(columns if by_action else columns[1:]))
    return [connection.execute(query.where(*conditions(_within(wanted, span)))).all() for span in spans]


async def tally_goals(history: History, wanted: GoalFilter, spans: Sequence[Span], *, by_action: bool) -> list[Tallies]:
    """Return how the wanted goals ended, for each span of the time when they were created.

    Goals that are not in the database yet are not counted: an ended goal is written before its end is published, or
    half a second after it.

    Raises:
        Unavailable: The database does not answer, takes too long, or does not have all goals (`history_unavailable`).
    """
    history.reader.require_everything()
    rows = await history.reader.read_much(read_rows, wanted, spans, by_action)
    return await asyncio.to_thread(tally_rows, rows)


def tally_rows(rows: "Iterable[Iterable[sa.Row[Any]]]") -> list[Tallies]:
    """Tally the rows of a database, for each span. Takes some 0.1 s for a million goals."""
    return [_tallies(map(tuple, each)) for each in rows]


def _milliseconds(connection: sa.Connection) -> "sa.ColumnElement[Any]":
    began, ended = goals.c.created_at, goals.c.finished_at
    if connection.dialect.name == "postgresql":
        return sa.cast(sa.func.round(sa.extract("epoch", ended - began) * 1000), sa.BigInteger)
    return sa.cast(sa.func.round((sa.func.julianday(ended) - sa.func.julianday(began)) * 86_400_000), sa.BigInteger)


# ---------------------------------------------------------------------- both


def _within(wanted: GoalFilter, span: Span) -> GoalFilter:
    return replace(wanted, since=span[0], until=span[1])


def _tallies(rows: "Iterable[tuple[Any, ...]]") -> Tallies:
    tallies: Tallies = {}
    for action_name, status_name, code, count, retries, reported, durations in rows:
        status = GoalStatus(status_name)
        if not status.terminal:
            continue
        tally = tallies.setdefault(action_name, Tally())
        tally.statuses[status] += count
        if code is not None:
            tally.errors[code] += count
        tally.retries += retries or 0
        tally.reported += reported
        if durations:
            tally.durations += parse_durations(durations)
    return tallies


def parse_durations(numbers: str) -> Iterator[Durations]:
    """Parse in pieces, so that no other thread waits for long: numpy holds the interpreter for each of them."""
    start = 0
    while start < len(numbers):
        end = numbers.find(",", start + PIECE)
        end = len(numbers) if end < 0 else end
        yield np.fromstring(numbers[start:end], sep=",")
        start = end + 1
