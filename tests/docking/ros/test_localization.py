import math

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped

from docking.ros.localization import LocalizationState


def _message(xx: float, xy: float, yy: float) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    message.pose.covariance[0], message.pose.covariance[7] = xx, yy
    message.pose.covariance[1] = message.pose.covariance[6] = xy
    return message


@pytest.mark.parametrize(
    ("covariance", "deviation"), [((0.01, 0.0, 0.04), 0.2), ((0.01, 0.0, 0.0), 0.1), ((0.02, 0.02, 0.02), 0.2)]
)
def test_the_deviation_is_that_along_the_longest_axis(covariance: tuple[float, float, float], deviation: float) -> None:
    state = LocalizationState()
    state.take(_message(*covariance), 0.0)
    assert state.error == pytest.approx(deviation)


def test_a_covariance_of_zeros_says_nothing_and_one_that_is_no_number_is_refused() -> None:
    state = LocalizationState()
    state.take(_message(0.0, 0.0, 0.0), 0.0)
    assert math.isnan(state.error)
    with pytest.raises(ValueError, match="not a number"):
        state.take(_message(math.nan, 0.0, 0.0), 0.0)


def test_the_same_transform_again_is_not_heard_again() -> None:
    state = LocalizationState()
    state.note(5.0, 100.0)
    state.note(5.0, 101.0)
    assert state.heard_at == 100.0
    state.note(5.1, 101.5)
    assert state.heard_at == 101.5
    state.note(None, 103.0)
    assert state.heard_at == 103.0, "what never changes is always new"
