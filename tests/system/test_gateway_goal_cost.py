"""What a goal costs with all defaults, in numbers that no other program on the machine changes.

A feature must cost a goal nothing on the goal's own way, unless it is used. Who adds to these numbers says why.
"""

import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import orjson
import pytest

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

# Goals that are measured, and seconds after each: until its recording would be finished.
GOALS, SECONDS = 3, 3.0
# A goal that is sent, succeeds at once, and is read once costs at most this. What is not here, it does not do.
COST = {
    # It is stored before it is sent; and once more, with all its events, after it has ended.
    "transaction queries.write": 2,
    # Both of these outlast a power cut.
    "synchronous transaction": 2,
    # That it runs is stored before its sender is answered, its end before that is published.
    "transaction queries.seal": 2,
    # Its request is in the audit log.
    "transaction immediate.ImmediateWriter.write.<locals>.write_in_time": 1,
    # Each transaction is handed to the one thread that writes.
    "thread history-write": 5,
    # It is read, and then its notes and tags.
    "read queries.goals_by_id": 1,
    "read notes._notes_of": 1,
    # It is sent, and its result is requested: the action protocol itself.
    "service /connect_to_charging_dock/_action/send_goal": 1,
    "service /connect_to_charging_dock/_action/get_result": 1,
    # The two answers, and messages of the status topic: accepted, executing, succeeded.
    "event loop bridge._settle": 2,
    "event loop inbox.Inboxes._serve": 3,
    # The recorder hears the same messages, and what else the robot says meanwhile.
    "event loop subscription.TopicSubscription._tell": 7,
    # While a goal may move the robot, its velocity is listened to.
    "ROS thread on_demand.OnDemand._open.<locals>.<lambda>": 1,
    "ROS thread opening._watch_wheels.<locals>.name.<locals>.<lambda>": 1,
}


@pytest.fixture
def counting(domain: int, tmp_path: Path) -> Iterator[tuple[RunningGateway, Path]]:
    """A gateway that counts, beside an action server whose goals succeed at once; and where its counts are."""
    file = tmp_path / "counts.json"
    server = ("-m", "tests.support.plain_action_server", "--feedbacks", "0")
    with ForkedProcess(*server, env=ros_environment(domain)) as process:
        process.wait_for("serving")
        counted = (sys.executable, "-m", "tests.support.counted", str(file))
        with running_gateway(domain, *counted, recordings="failed") as gateway:
            gateway.wait_until_ready()
            yield gateway, file


def count(gateway: RunningGateway, file: Path, *, goal: bool) -> Counter[str]:
    """What the gateway does in some seconds, with a goal or without one."""
    before = read(gateway, file)
    if goal:
        sent = gateway.http.post("/dock", headers={"Prefer": "wait=50"}).raise_for_status().json()
        assert gateway.goal(sent["goal_id"])["status"] == "succeeded"
    time.sleep(SECONDS)
    return read(gateway, file) - before


def read(gateway: RunningGateway, file: Path) -> Counter[str]:
    file.unlink(missing_ok=True)
    gateway.process.send_signal(signal.SIGUSR1)
    wait_until(file.exists, "the counts")
    return Counter(orjson.loads(file.read_bytes()))


def test_a_goal_costs_no_more_than_is_known(counting: tuple[RunningGateway, Path]) -> None:
    count(*counting, goal=True)  # the first one opens, imports and subscribes
    idle = count(*counting, goal=False) | count(*counting, goal=False)
    least = count(*counting, goal=True)
    for _ in range(GOALS - 1):
        least &= count(*counting, goal=True)  # a busy machine adds to some goals: to write twice, for example
    cost = {what: number for what, number in least.items() if what not in idle}
    assert {what: number for what, number in cost.items() if number > COST.get(what, 0)} == {}
    assert cost.keys() >= {name for name in COST if name.startswith(("transaction", "service"))}, "it is not counted"
