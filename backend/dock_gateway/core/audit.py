"""The audit log: what an entry says, and the chain of digests that shows whether entries were changed. Pure."""

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from typing import Any, NamedTuple

import orjson

# The digest before the first row.
GENESIS = "0" * 64
# Characters of a text in an entry, and of the robots of a stop.
MAX_TEXT, MAX_ROBOTS = 300, 10_000


class RequestOutcome(StrEnum):
    """The outcome of a request or a command."""

    DONE = "done"
    REFUSED = "refused"
    FAILED = "failed"


def outcome_of(status: int) -> RequestOutcome:
    """Return the outcome that a status code stands for."""
    if status < 400:
        return RequestOutcome.DONE
    return RequestOutcome.REFUSED if status < 500 else RequestOutcome.FAILED


@dataclass(frozen=True)
class AuditEntry:
    """One request or command: who did what, from where, to which robot, with which outcome.

    Attributes:
        id: Identifies the entry, so that a repeated write does not store it twice.
        acted_at: When the request acted, or arrived if it was refused.
        principal: The name of the token; None where the gateway asks for none, or there was no valid one.
        role: What they may do; None if there was no valid token.
        token_id: The token.
        client: IP address of the client, or of the proxy before it.
        request_id: The id of the request, if it has one.
        what: Name of the route, or the command of `/ws`.
        robot: Namespace of the robot; several are separated by commas.
        action_name: The action.
        goal_id: The goal.
        subject: Another subject, such as the name of a token or the id of a rule.
        status: The status code of the answer.
        code: Why it was refused or failed.
    """

    id: str
    acted_at: datetime
    principal: str | None
    role: str | None
    token_id: str | None
    client: str | None
    request_id: str | None
    what: str
    robot: str | None
    action_name: str | None
    goal_id: str | None
    subject: str | None
    status: int
    code: str | None

    def __post_init__(self) -> None:
        """Make every text one that each database stores unchanged: short, without NUL and lone surrogates."""
        for name, value in vars(self).items():
            if isinstance(value, str):
                object.__setattr__(self, name, _clean(value, MAX_ROBOTS if name == "robot" else MAX_TEXT))

    @property
    def outcome(self) -> RequestOutcome:
        """The outcome."""
        return outcome_of(self.status)


def _clean(text: str, longest: int) -> str:
    return text[:longest].encode(errors="replace").decode().replace("\0", "?")


class Link(NamedTuple):
    """A place in the chain: a row's number, and its digest."""

    sequence: int
    digest: str


START = Link(0, GENESIS)


@dataclass(frozen=True)
class AuditRow:
    """An entry as it is stored: with its number, and the digest over the previous row's and this entry."""

    sequence: int
    entry: AuditEntry
    digest: str

    @property
    def link(self) -> Link:
        """Its place in the chain."""
        return Link(self.sequence, self.digest)

    def document(self) -> dict[str, Any]:
        """Return the row as the API shows it."""
        return {"sequence": self.sequence, **vars(self.entry), "outcome": self.entry.outcome, "digest": self.digest}


def digest_of(previous: str, sequence: int, entry: AuditEntry) -> str:
    """Return the SHA-256 over the previous row's digest and the canonical JSON of this row.

    That is one object with its number and all fields of the entry, sorted, without spaces, the time in UTC with six
    decimals.
    """
    fields = {
        **vars(entry),
        "sequence": sequence,
        "acted_at": f"{entry.acted_at.astimezone(UTC):%Y-%m-%dT%H:%M:%S.%fZ}",
    }
    return hashlib.sha256(previous.encode() + orjson.dumps(fields, option=orjson.OPT_SORT_KEYS)).hexdigest()


def extend(last: Link, entries: Iterable[AuditEntry]) -> Iterator[AuditRow]:
    """Yield the rows that follow the last one."""
    sequence, digest = last
    for entry in entries:
        sequence += 1
        digest = digest_of(digest, sequence, entry)
        yield AuditRow(sequence, entry, digest)


@dataclass(frozen=True)
class Verdict:
    """The result of a check of the chain.

    Attributes:
        intact: Number of rows before the first fault.
        last: The last intact row, or the anchor if there is none.
        fault: The first fault; None if there is none.
    """

    intact: int
    last: Link
    fault: str | None = None


def verify(rows: Iterable[AuditRow], anchor: Link, head: Link, expected: str | None = None) -> Verdict:
    """Check the chain.

    Args:
        rows: All rows in the order of their numbers.
        anchor: The link before the first row: the last row that was deleted for its age.
        head: The last row that was written.
        expected: A digest that was copied earlier, and has to be the anchor's or that of a row.
    """
    last, intact = anchor, 0
    seen = expected in (None, anchor.digest)
    for row in rows:
        if row.sequence > last.sequence + 1:
            return Verdict(intact, last, f"{_rows(last.sequence + 1, row.sequence - 1)} removed")
        if row.sequence <= last.sequence or row.digest != digest_of(last.digest, row.sequence, row.entry):
            return Verdict(intact, last, f"row {row.sequence} was changed or inserted, or took the place of another")
        last, intact = row.link, intact + 1
        seen = seen or row.digest == expected
    if last.sequence < head.sequence:
        return Verdict(intact, last, f"{_rows(last.sequence + 1, head.sequence)} removed")
    if last != head:
        return Verdict(intact, last, f"the last row is not the one that a gateway wrote last, row {head.sequence}")
    if not seen:
        return Verdict(intact, last, f"no row has the digest {expected}: the rows were replaced, or it was deleted")
    return Verdict(intact, last)


def _rows(first: int, last: int) -> str:
    return f"row {first} was" if first == last else f"rows {first} to {last} were"


@dataclass(frozen=True)
class AuditFilter:
    """A query for entries. An entry must meet all conditions; None means any.

    Attributes:
        principal: By this token.
        what: This route or command.
        robot: About this robot.
        goal_id: About this goal.
        outcome: With this outcome.
        since: At this time or later.
        until: Before this time.
    """

    principal: str | None = None
    what: str | None = None
    robot: str | None = None
    goal_id: str | None = None
    outcome: RequestOutcome | None = None
    since: datetime | None = None
    until: datetime | None = None

    def matches(self, entry: AuditEntry) -> bool:
        """Return whether an entry meets all conditions."""
        return (
            self.principal in (None, entry.principal)
            and self.what in (None, entry.what)
            and (self.robot is None or self.robot in robots_of(entry))
            and self.goal_id in (None, entry.goal_id)
            and self.outcome in (None, entry.outcome)
            and (self.since is None or entry.acted_at >= self.since)
            and (self.until is None or entry.acted_at < self.until)
        )


def robots_of(entry: AuditEntry) -> list[str]:
    """Return the robots that an entry names."""
    return [] if entry.robot is None else entry.robot.split(",")
