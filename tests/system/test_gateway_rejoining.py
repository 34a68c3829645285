"""A gateway that an action server's answers do not reach, as after an outage: it reaches the server another way."""

import asyncio
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import orjson
import pytest

from dock_gateway.assembly import open_gateway
from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.extension import extensions
from dock_gateway.goals.limits import GoalLimits
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.ros.bridge import Bridge
from dock_gateway.settings import Settings
from tests.support.gateway import running_program
from tests.support.rejoining import lose_answers
from tests.support.waiting import until

pytestmark = pytest.mark.ros

# On a busy machine, another participant may take longer than a result is usually waited for.
LIMITS = GoalLimits(unanswered_for=0.5, home_after=1.0, result_wait=30.0)


@pytest.fixture
def settings(domain: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Settings]:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    with running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.3"):
        yield Settings(
            database_url="memory:",
            spool_path=tmp_path / "spool",
            stop_path=tmp_path / "stops.json",
            server_wait=30,
            cancel_timeout=0.3,  # given up before another participant is tried, which would send it again
        )


async def read(subscriber: Subscriber, into: list[dict[str, Any]]) -> None:
    while True:
        into += [orjson.loads(event.data) for event in (await subscriber.take(60))[0]]


async def test_goals_and_readers_stay_while_the_server_is_reached_another_way(settings: Settings) -> None:
    async with open_gateway(settings, extensions(), LIMITS) as parts:
        bridge = parts[Bridge]
        action = await parts[ActionRegistry].find("/fibonacci")
        events: list[dict[str, Any]] = []
        reading = asyncio.create_task(read(parts[Fanout].subscribe(EventFilter()), events))
        goal = await action.delivery.start(action.port.goal_codec.parse({"order": 46}), sender=ANYBODY)
        await until(lambda: goal.feedback_count > 0)
        with pytest.MonkeyPatch.context() as patch:
            lose_answers(bridge, patch)
            with pytest.raises(GatewayError):  # the server did cancel it, but the answer was lost
                await action.canceler.cancel(goal)
            await until(lambda: action.port.away)
            await until(lambda: goal.status.final)
        await until(lambda: not action.port.away)
        await until(lambda: not bridge.branches)
        reading.cancel()
    mine = [event for event in events if event.get("goal_id") == goal.goal_id]
    assert mine[-1]["status"] == "canceled"
    assert [event["type"] for event in mine].count("result") == 1
    assert mine[-1]["result"]["sequence"]
    assert not any(event["type"] == "dropped" for event in events)
    counts = [len(event["feedback"]["partial_sequence"]) for event in mine if event["type"] == "feedback"]
    assert all(later == earlier + 1 for earlier, later in pairwise(counts))
