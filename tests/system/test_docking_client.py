"""The clients as processes: the tutorial's words, Ctrl-C, and an exit code for everything that can happen."""

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from action_msgs.srv import CancelGoal

from tests.support.docking import ACTION, CHARGING, LOW, dock_server, send_dock_goal
from tests.support.observer import Observer
from tests.support.processes import PATIENT_CLIENT, ForkedProcess, Process, client_process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

CLIENT = "connect_to_charging_dock_client"
RUN = Path(sys.prefix) / "lib/action_tutorials_py"  # what `ros2 run action_tutorials_py` starts
FEEDBACK = "Received feedback (1 = CHARGING, 3 = NOT CHARGING): 3"


def test_the_tutorials_session(domain: int, observer: Observer) -> None:
    environment = ros_environment(domain)
    with (
        Process(str(RUN / "connect_to_charging_dock_server"), env=environment) as server,
        Process(str(RUN / CLIENT), *PATIENT_CLIENT, env=environment) as client,
    ):
        with observer.publishing(LOW, "battery_status"):
            for line in ("Goal accepted...", FEEDBACK):
                client.wait_for(line)
            for line in ("Executing goal...", "NOT CHARGING..."):
                server.wait_for(line)
            nodes = {"battery_state_subscriber", "connect_to_charging_dock_action_server"}
            wait_until(lambda: nodes <= set(observer.node.get_node_names()), "the nodes of the tutorial")
        observer.publish(CHARGING, "battery_status")
        client.wait_for("Result (1 = CHARGING, 3 = NOT CHARGING): 1")
        assert client.wait() == 0
        server.wait_for("]: CHARGING...")
        server.wait_for("Successfully connected to the charging dock!")


def test_ctrl_c_cancels_the_goal_and_waits_for_its_end(domain: int, observer: Observer) -> None:
    with (
        dock_server(domain),
        observer.publishing(LOW, "battery_status"),
        client_process(domain, CLIENT) as client,
    ):
        client.wait_for(FEEDBACK)
        client.send_signal(signal.SIGINT)
        client.wait_for("The goal was canceled")
        assert client.wait() == 130
        assert send_dock_goal(observer).accepted, "the dock is free again"


def test_a_rejected_goal_is_explained(domain: int) -> None:
    with dock_server(domain), client_process(domain, CLIENT, "--status", "3") as client:
        assert "3 (NOT_CHARGING)" in client.wait_for("The goal was rejected: ")
        assert client.wait() == 3


def test_an_aborted_goal_is_explained(domain: int) -> None:
    parameters = ("battery_stale_after:=0.1", "battery_lost_after:=0.3")
    with dock_server(domain, *parameters), client_process(domain, CLIENT) as client:
        assert "no battery message" in client.wait_for("The goal was aborted: ")
        assert client.wait() == 1


def test_a_goal_without_a_battery_names_the_batteries_that_there_are(domain: int, observer: Observer) -> None:
    parameters = ("battery_stale_after:=0.1", "battery_lost_after:=8.0")
    with (
        dock_server(domain, *parameters),
        observer.publishing(LOW, "/robot1/battery_state", heard=False),
        client_process(domain, CLIENT) as client,
    ):
        expected = "nothing comes on /battery_status, but batteries are on /robot1/battery_state: remap battery_status"
        assert expected in client.wait_for("The goal was aborted: ")


def test_a_cancel_by_someone_else_is_told(domain: int, observer: Observer) -> None:
    with dock_server(domain), client_process(domain, CLIENT) as client:
        client.wait_for("Goal accepted...")
        observer.ask(CancelGoal, f"{ACTION}/_action/cancel_goal", CancelGoal.Request())
        client.wait_for("The goal was canceled")
        assert client.wait() == 4


def test_without_a_server_it_ends_after_the_timeout(domain: int) -> None:
    with ForkedProcess(CLIENT, "--timeout", "0.5", env=ros_environment(domain)) as client:
        client.wait_for("No action server answered within 0.5 s")
        assert client.wait() == 5


@pytest.fixture
def server_process(domain: int) -> Iterator[Process]:
    with ForkedProcess("connect_to_charging_dock_server", env=ros_environment(domain)) as process:
        yield process


def test_a_server_that_dies_is_noticed(domain: int, server_process: Process) -> None:
    with client_process(domain, CLIENT) as client:
        client.wait_for("Received feedback")
        server_process.send_signal(signal.SIGKILL)
        client.wait_for("No response from the action server")
        assert client.wait() == 6


def test_a_wrong_command_line_is_refused(domain: int) -> None:
    with ForkedProcess(CLIENT, "--status", "fast", env=ros_environment(domain)) as client:
        assert client.wait() == 2
        assert "invalid" in client.output


def test_fibonacci_counts_as_in_the_official_tutorial(domain: int) -> None:
    environment = ros_environment(domain)
    server_command = (str(RUN / "fibonacci_action_server"), "--ros-args", "-p", "step_period:=0.1")
    with Process(*server_command, env=environment) as server:
        with Process(str(RUN / "fibonacci_action_client"), *PATIENT_CLIENT, env=environment) as client:
            client.wait_for("Received feedback: [0, 1, 1]")
            client.wait_for("Received feedback: [0, 1, 1, 2, 3, 5, 8]")
            client.wait_for("Result: [0, 1, 1, 2, 3, 5, 8, 13, 21, 34, 55]")
            assert client.wait() == 0
        with client_process(domain, "fibonacci_action_client", "--order", "46") as client:
            client.wait_for("Received feedback")
            client.send_signal(signal.SIGINT)
            server.wait_for("Goal canceled")
            assert client.wait() == 130
        with client_process(domain, "fibonacci_action_client", "--order", "46") as client:
            client.wait_for("Received feedback")
            server.send_signal(signal.SIGTERM)
            client.wait_for("The goal was aborted")
            assert (client.wait(), server.wait()) == (1, 0)


def test_fibonacci_refuses_what_does_not_fit_in_an_int32(domain: int) -> None:
    environment = ros_environment(domain)
    with (
        ForkedProcess("fibonacci_action_server", env=environment) as server,
        client_process(domain, "fibonacci_action_client", "--order", "47") as client,
    ):
        server.wait_for("order is 47, but must be from 0 to 46")
        assert client.wait() == 3
