"""Which of several gateways sends the goal of a step."""

from datetime import timedelta

import pytest

from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.moves import Change, Facts, Send, Wait, WaitsFor
from dock_gateway.extensions.missions.progress import cancel, next_move
from dock_gateway.extensions.missions.sender import SENDS_FOR
from tests.extensions.missions.examples import FIBONACCI, NOON, after, begun

ONE, OTHER = Facts(gateway="one"), Facts(gateway="other")
OVER = SENDS_FOR.total_seconds()


def try_of_one() -> MissionEntry:
    move = next_move(begun(FIBONACCI | {"timeout_s": 30}), ONE, NOON)
    assert isinstance(move, Change)
    return move.mission


@pytest.mark.parametrize("seconds", [0, 31, OVER - 1])
def test_while_one_may_send_the_other_takes_the_mission_no_further(seconds: float) -> None:
    mission = try_of_one()
    waiting = Wait(WaitsFor.GOAL, NOON + SENDS_FOR)
    assert next_move(mission, OTHER, after(seconds)) == waiting  # also if the step has taken too long
    assert next_move(cancel(mission, NOON), OTHER, after(seconds)) == waiting
    assert next_move(mission, ONE, NOON) == Send()


def test_once_the_goal_is_stored_both_follow_it() -> None:
    mission = try_of_one().with_step(goal_id="goal")
    for facts in (ONE, OTHER):
        assert isinstance(next_move(mission, facts, after(31)), Change)


def test_another_one_takes_over_and_then_the_first_waits() -> None:
    mission = try_of_one().with_step(timeout_s=None)
    move = next_move(mission, OTHER, after(OVER))
    assert isinstance(move, Change)
    assert (move.mission.current.sender, move.mission.current.attempt) == ("other", 1)
    assert next_move(move.mission, OTHER, after(OVER)) == Send()
    assert next_move(move.mission, ONE, after(OVER)) == Wait(WaitsFor.GOAL, after(OVER) + SENDS_FOR)


def test_one_that_waits_for_a_server_extends_its_time() -> None:
    mission = try_of_one().with_step(timeout_s=None)
    assert next_move(mission, ONE, after(OVER / 2 - 1)) == Send()
    move = next_move(mission, ONE, after(OVER / 2))
    assert isinstance(move, Change)
    assert move.mission.current.sends_until == after(OVER / 2) + SENDS_FOR
    assert next_move(move.mission, ONE, after(OVER / 2)) == Send()


def test_a_canceled_one_ends_once_nobody_may_send_it() -> None:
    move = next_move(cancel(try_of_one(), NOON), OTHER, NOON + SENDS_FOR + timedelta(seconds=1))
    assert isinstance(move, Change)
    assert move.mission.status is MissionStatus.CANCELED


def test_a_gateway_that_is_alone_has_all_the_time() -> None:
    move = next_move(begun(FIBONACCI), Facts(), NOON)
    assert isinstance(move, Change)
    assert next_move(move.mission, Facts(), after(10 * OVER)) == Send()
