import math

import pytest

from docking.clients.dock import DockClient
from docking.clients.goal_client import parse_arguments
from docking.clients.undock import UndockClient
from docking.tutorial.fibonacci_client import FibonacciClient


def test_the_dock_client_sends_the_tutorials_goal_by_default() -> None:
    options = parse_arguments(DockClient, [])
    assert (options.voltage, options.percentage, options.status) == (2.16, 0.24, 1)


def test_the_undock_client_asks_for_a_battery_that_is_not_charging() -> None:
    assert parse_arguments(UndockClient, []).status == 3


def test_the_dock_client_sends_what_it_is_told() -> None:
    options = parse_arguments(DockClient, ["--voltage", "12", "--percentage", "nan", "--status", "4"])
    assert (options.voltage, options.status) == (12.0, 4)
    assert math.isnan(options.percentage)


@pytest.mark.parametrize(
    "arguments",
    [
        ["--status", "256"],
        ["--status", "-1"],
        ["--voltage", "1e39"],
        ["--voltage", "inf"],
        ["--timeout", "0"],
        ["extra"],
    ],
)
def test_the_dock_client_refuses_nonsense(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refusal:
        parse_arguments(DockClient, arguments)
    assert refusal.value.code == 2
    assert arguments[-1] in capsys.readouterr().err


def test_the_fibonacci_client_counts_to_the_tenth_by_default() -> None:
    assert parse_arguments(FibonacciClient, []).order == 10
    assert parse_arguments(FibonacciClient, ["--order", "-3"]).order == -3


def test_the_fibonacci_client_refuses_what_is_no_int32() -> None:
    with pytest.raises(SystemExit):
        parse_arguments(FibonacciClient, ["--order", str(2**31)])
