"""Schedules of real gateways: a mission is queued once by two, and what was missed is made up."""

import signal
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

MISSION: dict[str, Any] = {"name": "Round", "steps": [{"wait": {"seconds": 0}}]}


def store(gateway: RunningGateway, seconds: float) -> datetime:
    """Store a schedule that is due in some seconds; return when."""
    at = datetime.now(UTC) + timedelta(seconds=seconds)
    body = {"mission": MISSION, "once": {"due_at": at.isoformat()}}
    assert gateway.http.put("/schedules/round", json=body).status_code == 201
    return at


def outcome(gateway: RunningGateway) -> dict[str, Any] | None:
    found: dict[str, Any] | None = gateway.http.get("/schedules/round").raise_for_status().json()["last"]
    return found


def test_two_gateways_on_one_database_queue_one_mission(domain: int, tmp_path: Path) -> None:
    database = f"sqlite:///{tmp_path}/history.db"
    with (
        running_gateway(domain, database_url=database) as first,
        running_gateway(domain, database_url=database) as second,
    ):
        at = store(first, 4.0)
        last = wait_until(lambda: outcome(second), "the time")
        assert datetime.fromisoformat(last["due_at"]) == at
        missions = first.http.get("/missions").json()["missions"]
        assert [(each["mission_id"], each["schedule"]) for each in missions] == [(last["mission_id"], "round")]
        assert first.http.get("/schedules/round").json()["next_at"] is None
        is_over = lambda: second.http.get(f"/missions/{last['mission_id']}").json()["status"] == "succeeded"  # noqa: E731
        wait_until(is_over, "its end")


def test_what_was_missed_is_made_up_after_a_restart(domain: int, tmp_path: Path) -> None:
    kept = {"database_url": f"sqlite:///{tmp_path}/history.db", "spool_path": f"{tmp_path}/spool"}
    with running_gateway(domain, **kept) as first:
        at = store(first, 5.0)
        first.process.send_signal(signal.SIGKILL)
        first.process.wait()
    assert datetime.now(UTC) < at
    while datetime.now(UTC) <= at:
        time.sleep(0.1)
    with running_gateway(domain, **kept) as second:
        last = wait_until(lambda: outcome(second), "what was missed")
        assert last["mission_id"] is not None
        assert len(second.http.get("/missions").json()["missions"]) == 1
