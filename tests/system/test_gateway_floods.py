"""One ROS node that sends too much, too fast or too large harms nobody else."""

import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import test_msgs

from dock_gateway.ros.admission import MAX_UNKNOWN
from tests.support.gateway import (
    ACTION,
    LOW,
    RunningGateway,
    running_dock_server,
    running_gateway,
    running_hostile_node,
)
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

LIMIT = 20_000
# Seconds that a stop may take on a busy machine.
QUICK = 5.0


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with running_gateway(shared_domain, max_message_bytes=str(LIMIT)) as gateway:
        yield gateway


def answers_while_flooded(gateway: RunningGateway, seconds: float = 2.0) -> None:
    """Stops and a stream's battery events go on meanwhile."""
    gateway.publish(LOW, rate_hz=20.0)
    with gateway.stream("?include=battery") as stream:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            began = time.monotonic()
            gateway.stop_once()
            assert time.monotonic() - began < QUICK
            stream.until_type("battery", timeout=QUICK)


def test_feedback_that_is_too_large_is_told_and_counted(gateway: RunningGateway, shared_domain: int) -> None:
    arguments = ("big_feedback", "--size", str(10 * LIMIT), "--rate", "20")
    with gateway.stream() as stream, running_hostile_node(shared_domain, *arguments):
        event = stream.until_type("feedback_dropped")
        assert (event["reason"], event["action_name"]) == ("feedback_too_large", ACTION)
        assert event["count"] > 1
        assert gateway.goal(event["goal_id"])["status"] == "executing"
        answers_while_flooded(gateway)
        action = gateway.http.get(f"/actions{ACTION}").json()
        assert action["feedback_dropped"] >= event["count"]
        assert not [event for event in stream.seen if event["type"] == "feedback"]


def test_goals_that_a_node_makes_up_are_ignored_before_they_cost_anything(domain: int) -> None:
    """A goal of a real server is found and followed meanwhile, whoever sent it, and a stop is carried out."""
    with (
        running_gateway(domain) as gateway,
        running_gateway(domain) as other,
        running_dock_server(domain),
        running_hostile_node(domain, "unknown_goals", "--rate", "300"),
    ):
        wait_until(lambda: action_of(gateway)["unknown_goals_ignored"] > 3 * MAX_UNKNOWN, "a flood")
        named = gateway.process.wait_for("unknown goals in")
        assert f"/hostile_unknown_goals names more than {MAX_UNKNOWN} unknown goals" in named
        assert named.endswith(str(action_of(gateway)["hint"]))
        other.wait_until_ready()
        other.publish(LOW)
        goal = other.http.post("/dock").raise_for_status().json()
        wait_until(lambda: gateway.http.get(f"/goals/{goal['goal_id']}").status_code == 200, "the goal")
        with gateway.stream(f"?goal_id={goal['goal_id']}") as stream:
            stream.until_type("feedback")
        ignored = action_of(gateway)["unknown_goals_ignored"]
        answers_while_flooded(gateway)
        assert gateway.wait_for_goal(goal["goal_id"], "canceled")["origin"] == "external"
        assert action_of(gateway)["unknown_goals_ignored"] > ignored
        publishers = gateway.process.output.count("unknown goals in")
        assert publishers in (1, 2), "it is told once for each topic"
        assert len(externals(gateway)) <= 1 + 4 * MAX_UNKNOWN, "a limit for each publisher and period"
        metrics = gateway.http.get("/metrics").text
        assert "dock_gateway_unknown_goals_ignored_total 0.0" not in metrics


def action_of(gateway: RunningGateway) -> dict[str, Any]:
    answer: dict[str, Any] = gateway.http.get(f"/actions{ACTION}").json()
    return answer


def externals(gateway: RunningGateway) -> list[dict[str, Any]]:
    goals = gateway.http.get("/goals?limit=500").raise_for_status().json()["goals"]
    return [goal for goal in goals if goal["origin"] == "external"]


def test_a_battery_state_that_is_too_large_is_not_read(gateway: RunningGateway, shared_domain: int) -> None:
    arguments = ("battery", "--topic", "/large/battery_status", "--size", str(10 * LIMIT), "--rate", "20")
    with running_hostile_node(shared_domain, *arguments):
        wait_until(lambda: gateway.http.get("/battery?robot=/large").status_code == 200, "the robot")
        answers_while_flooded(gateway)
        assert gateway.http.get("/battery?robot=/large").json()["state"] is None


def test_a_result_that_is_too_large_ends_the_goal_without_it(gateway: RunningGateway, shared_domain: int) -> None:
    command = ("-m", "tests.support.plain_action_server", "--feedbacks", "1")
    with ForkedProcess(*command, "--result-bytes", str(2 * LIMIT), env=ros_environment(shared_domain)) as server:
        server.wait_for("serving")
        gateway.wait_until_ready()
        goal = gateway.http.post("/dock", headers={"Prefer": "wait=50"}).json()
        assert (goal["status"], goal["result"]) == ("succeeded", None)
        assert goal["error"]["code"] == "result_too_large"


@pytest.fixture(params=["raises", "no type support"])
def broken_package(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A folder with a `test_msgs` that does not work, as if it were built for another Python."""
    package = tmp_path / "test_msgs"
    shutil.copytree(Path(test_msgs.__path__[0]), package, ignore=shutil.ignore_patterns("*.so", "__pycache__"))
    package.joinpath("test_msgs_s__rosidl_typesupport_c.cpython-27.so").touch()
    if request.param == "raises":
        package.joinpath("action", "__init__.py").write_text("raise RuntimeError('for another Python')")
    return tmp_path


def test_actions_that_cannot_be_used_keep_no_other_from_being_found(
    domain: int, broken_package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running_hostile_node(domain, "odd_actions"):
        monkeypatch.setenv("PYTHONPATH", str(broken_package))
        with running_gateway(domain, "env") as gateway:
            monkeypatch.undo()
            found = wait_until(lambda: odd_ones(gateway, 3), "the actions")
            assert found["/a_first/other"]["installed"] is False
            assert "test_msgs" in found["/a_first/other"]["hint"]
            assert found["/b_second/two_types"]["action_type"].endswith("Fibonacci")
            with running_dock_server(domain, "-r", "__ns:=/z_last"):
                wait_until(lambda: gateway.http.get("/battery?robot=/z_last").status_code == 200, "the robot")
                assert gateway.http.post("/dock?robot=/z_last").status_code in (202, 409)


def odd_ones(gateway: RunningGateway, count: int) -> dict[str, Any]:
    actions = gateway.http.get("/actions").json()["actions"]
    found = {action["action_name"]: action for action in actions if action["action_name"].count("/") > 1}
    return found if len(found) >= count else {}


def test_hundreds_of_actions_at_once(domain: int) -> None:
    with (
        running_gateway(domain, max_actions="60", max_robots="20") as gateway,
        running_hostile_node(domain, "actions", "--count", "100"),
    ):
        found = wait_until(lambda: odd_ones(gateway, 100), "the actions")
        answers_while_flooded(gateway)
        assert sum(action["installed"] for action in found.values()) == 58
        assert {action["hint"] for action in found.values() if not action["installed"]} == {
            "the limit of 60 is reached, see max_actions"
        }
        assert len(gateway.http.get("/robots").json()["robots"]) == 20
