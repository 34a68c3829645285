"""Gateways that are killed at random moments under load: no goal is missing, repeated or reported twice."""

import os
import random
import time
from collections import Counter
from pathlib import Path

import pytest

from tests.chaos.fleet import Fleet, wait_for_action
from tests.chaos.load import FINAL, Load
from tests.chaos.report import report
from tests.support.postgresql import binaries, running_postgresql

pytestmark = [pytest.mark.ros, pytest.mark.timeout(3600)]

ROUNDS = int(os.environ.get("CHAOS_ROUNDS", "2"))


def check(load: Load, fleet: Fleet, executed: Path, kills: int, title: str) -> None:
    """What must hold after any number of kills.

    Args:
        load: Who sent goals and read events.
        fleet: The gateways.
        executed: The file of the action server.
        kills: How many there were.
        title: Of the report.
    """
    accepted, reader = load.accepted, load.reader
    began = Counter(map(int, executed.read_text().split()))
    http = fleet.any().http
    missing, wrong, histories, stored = [], [], Counter[int](), {}
    for number, goal_id in accepted.items():
        answer = http.get(f"/goals/{goal_id}")
        if answer.status_code != 200:
            missing.append(goal_id)
            continue
        goal = answer.json()
        if (goal["status"], goal["error"], goal["result"], goal["origin"]) != (
            "succeeded",
            None,
            {"sequence": [number]},
            "gateway",
        ):
            wrong.append(
                {name: goal[name] for name in ("goal_id", "status", "error", "result", "origin", "finished_at")}
            )
        events = http.get(f"/goals/{goal_id}/history?type=result&type=status").json()["events"]
        ends = [e["type"] for e in events if e["status"] in FINAL]
        stored[goal_id] = [e["id"] for e in events]
        histories[ends == ["status", "result"]] += 1
    late = fleet.told_before_stored()
    goals = set(accepted.values()) - late
    results, statuses = reader.ends("result"), reader.ends("status")
    ids = Counter(event["id"] for event in reader.events)
    first = min(ids)
    untold = [each for goal_id in goals for each in stored.get(goal_id, []) if each > first and not ids[each]]
    answers = sum((sender.answers for sender in load.senders), Counter[str]())
    report(
        title,
        {
            "kills": kills,
            "goals accepted": len(accepted),
            "of these reported before they were stored, as the log says": len(late),
            "goals missing": len(missing),
            "goals that did not end as the server ended them": len(wrong),
            "goals executed twice": sum(count > 1 for count in began.values()),
            "results reported": sum(results[goal_id] for goal_id in goals),
            "goals whose end was reported twice": sum(results[g] > 1 or statuses[g] > 1 for g in goals),
            "goals whose end was not reported": sum(not results[g] or not statuses[g] for g in goals),
            "goals with another number of ends in the history": histories[False],
            "events read": len(reader.events),
            "event ids read twice": sum(count > 1 for count in ids.values()),
            "events older than `after`": len(reader.older),
            "states and results stored": sum(map(len, stored.values())),
            "of these not reported": len(untold),
            "streams resumed": reader.notices["resumed"],
            "streams with a gap": reader.notices["gap"],
            "answers": dict(answers),
            "warnings": dict(fleet.warnings()),
        },
    )
    for goal_id in goals:
        if results[goal_id] != 1:
            print("the end of", goal_id, "was told", results[goal_id], "times; it is stored as", stored[goal_id])
            print("the reader resumed after", *reader.resumed, sep="\n  ")
    assert len(accepted) > kills
    assert missing == []
    assert wrong == [], wrong
    assert [number for number, count in began.items() if count > 1] == []
    odd = {goal_id for goal_id in goals if (results[goal_id], statuses[goal_id]) != (1, 1)}
    assert odd == set()
    assert histories[False] == 0
    # Where the database takes longer than a second, a reader that moves to another gateway may miss a state.
    assert [each for each in untold if not fleet.database_was_slow(int(each[:20]) / 1e9)] == []
    repeated = [identity for identity, count in ids.items() if count > 1]
    older = [identity for _, identity in reader.older]
    assert [each for each in (*repeated, *older) if not any(goal_id in each for goal_id in late)] == []
    assert reader.notices["gap"] == 0, "nothing has been deleted"


def test_a_gateway_that_is_killed_under_load(domain: int, executed: Path, tmp_path: Path) -> None:
    settings = {"database_url": f"sqlite:///{tmp_path}/history.db", "spool_path": f"{tmp_path}/spool"}
    with Fleet(domain, 1, **settings) as fleet:
        wait_for_action(fleet)
        with Load(fleet.url) as load:
            for _ in range(ROUNDS):
                time.sleep(random.uniform(0.1, 2.5))
                fleet.kill(0)
                fleet.start(0)
            time.sleep(1)
            load.stop_sending()
            load.wait_for_all_ends()
            check(load, fleet, executed, ROUNDS, "One gateway on SQLite, killed under load")


@pytest.mark.skipif(binaries() is None, reason="no PostgreSQL is installed")
def test_gateways_that_are_killed_in_turn_while_a_reader_resumes_at_the_other(
    domain: int, executed: Path, tmp_path: Path
) -> None:
    with (
        running_postgresql() as server,
        Fleet(domain, 2, database_url=server.url, spool_path=f"{tmp_path}/spool") as fleet,
    ):
        wait_for_action(fleet)
        with Load(fleet.url) as load:
            for turn in range(ROUNDS):
                time.sleep(random.uniform(0.1, 2.5))
                fleet.kill(turn % 2) if turn % 4 < 2 else fleet.end(turn % 2)
                time.sleep(random.uniform(0.0, 0.5))
                fleet.start(turn % 2)
            time.sleep(1)
            load.stop_sending()
            load.wait_for_all_ends()
            check(load, fleet, executed, ROUNDS, "Two gateways on PostgreSQL, killed or ended in turn")
