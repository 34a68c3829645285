"""The record of requests: a flood is counted, and everybody else is recorded."""

from dock_gateway.audit.record import RECORD_LIMITS, RecordLimits, RequestRecord
from dock_gateway.core.audit import AuditEntry
from tests.support.audit import make_entry
from tests.support.waiting import until


def recorded(limits: RecordLimits) -> tuple[RequestRecord, list[AuditEntry]]:
    record, entries = RequestRecord(limits), list[AuditEntry]()
    record.on_entry.append(entries.append)
    return record, entries


async def test_a_flood_without_a_token_is_counted() -> None:
    record, entries = recorded(RecordLimits(period=0.5))
    most = RECORD_LIMITS.unknown
    for number in range(100_000):
        record.record(make_entry(number, principal=None, role=None, token_id=None, status=401))
    assert len(entries) == most
    record.record(make_entry(100_000))  # of somebody who is known
    await until(lambda: len(entries) == most + 2)
    assert entries[most] == make_entry(100_000)
    assert (entries[-1].what, entries[-1].subject) == (
        "more_requests",
        f"{100_000 - most} more requests without a valid token",
    )
    record.record(make_entry(7, role=None))  # in the next period
    assert len(entries) == most + 3
    record.end_period()


async def test_one_user_who_floods_is_counted_and_others_are_recorded() -> None:
    record, entries = recorded(RecordLimits(period=0.5, of_user=5))
    for number in range(50):
        record.record(make_entry(number, principal="eve"))
    record.record(make_entry(50))
    await record.store(make_entry(51, principal="eve", what="release_stop"))
    await until(lambda: len(entries) == 8)
    assert entries[5:7] == [make_entry(50), make_entry(51, principal="eve", what="release_stop")]
    assert (entries[7].what, entries[7].subject, entries[7].outcome) == (
        "more_requests",
        "45 more requests of eve",
        "refused",
    )
