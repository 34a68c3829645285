"""How fast the base slows down is learned where it comes to a standstill."""

import math

import pytest

from docking.estimation.braking import Braking

DT = 0.05


def stop(
    braking: Braking,
    base: float,
    ramp: float,
    *,
    speed: float = 0.26,
    lag: float = 0.0,
    hit: bool = False,
    begin: float = 0.0,
) -> None:
    """From a standstill to a speed, and back: the command slows down by `ramp`, the base by `base` at most, in m/s².

    Args:
        braking: Learns.
        base: What the base can do.
        ramp: What is commanded.
        speed: The highest, in m/s.
        lag: How much later the base does what is commanded, in s.
        hit: Whether the base runs into something, and is commanded on.
        begin: When, in s.
    """
    measured, commands = 0.0, list[float]()
    for step in range(240):
        time = step * DT
        commands.append(min(speed, 0.5 * time) if time < 3.0 or hit else max(0.0, speed - ramp * (time - 3.0)))
        wanted = commands[max(0, step - round(lag / DT))]
        slowed = max(wanted, measured - base * DT) if wanted < measured else wanted
        measured = 0.0 if hit and time > 3.0 else slowed
        braking.add(begin + time, measured, commands[-1])


def learned() -> Braking:
    return Braking(at_rest=0.02, least=0.1)


@pytest.mark.parametrize("base", [0.05, 0.1, 0.15])
@pytest.mark.parametrize("lag", [0.0, 0.4])
@pytest.mark.parametrize("ramp", [0.3, 5.0], ids=["ramp", "at once"])
def test_a_base_that_brakes_less_than_commanded_is_found_out(base: float, lag: float, ramp: float) -> None:
    braking = learned()
    stop(braking, base, ramp, lag=lag)
    assert braking.limit == pytest.approx(base, rel=0.1)


@pytest.mark.parametrize("lag", [0.0, 0.2, 0.4])
@pytest.mark.parametrize("ramp", [0.15, 0.3, 0.5])
def test_a_base_that_brakes_as_commanded_has_no_limit_however_late_it_is(lag: float, ramp: float) -> None:
    braking = learned()
    stop(braking, 1.0, ramp, lag=lag)
    assert braking.limit == math.inf
    assert braking.shown == pytest.approx(ramp, rel=0.1)


def test_what_stops_the_robot_is_no_brake() -> None:
    braking = learned()
    stop(braking, 1.0, 0.3, hit=True)
    assert (braking.limit, braking.shown) == (math.inf, 0.0)


def test_a_slow_robot_shows_nothing() -> None:
    braking = learned()
    stop(braking, 0.05, 5.0, speed=0.08)
    assert (braking.limit, braking.shown) == (math.inf, 0.0)


def test_a_base_that_turns_out_to_brake_well_has_no_limit_any_more() -> None:
    braking = learned()
    stop(braking, 0.1, 0.3)
    assert braking.limit < 0.2
    stop(braking, 1.0, 0.3, begin=100.0)
    assert braking.limit == math.inf


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_counts_in_either_direction(sign: float) -> None:
    braking = learned()
    for step in range(200):
        braking.add(step * DT, sign * max(0.0, 0.3 - 0.1 * step * DT), 0.0 if step else sign * 0.3)
    assert braking.limit == pytest.approx(0.1, rel=0.1)
