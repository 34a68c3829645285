"""How fast the robot may drive, above all near the dock."""

import math
from collections import deque

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.errors import FailedToControl
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.estimation.motion_model import MotionModel
from docking.goal.pace import NEAR, Limiter, Pace
from docking.goal.plan import KnownPoses
from docking.parameters import MotionLimits

LIMITS = MotionLimits()
RADIUS = 0.06
PERIOD = 0.05
DOCKED = Pose(1.0, 0.5, 0.4)
POSES = KnownPoses(DOCKED, DOCKED, DOCKED.compose(Pose(-0.7)))
FAST = Velocity(0.26, 0.0)


class Base:
    """A base on the dock's axis, in front of the dock, and the pace of its goal."""

    def __init__(
        self,
        distance: float,
        *,
        dead_zone: float = 0.0,
        wall: float = math.inf,
        lag: float = 0.0,
        scale: float = 1.0,
        docked: Pose = DOCKED,
    ) -> None:
        self.x, self.now, self.docked = -distance, 0.0, docked
        self.model, self.pace = MotionModel(), Pace(LIMITS, RADIUS)
        self.velocities: list[tuple[float, float]] = []
        self._dead_zone, self._wall, self._scale = dead_zone, wall, scale
        self._coming = deque([0.0] * round(lag / PERIOD))
        self.frozen: Pose | None = None

    @property
    def pose(self) -> Pose:
        return self.docked.compose(Pose(self.x))

    def drive(self, wish: Velocity, seconds: float, poses: KnownPoses = POSES) -> None:
        for _ in range(round(seconds / PERIOD)):
            seen = self.frozen or self.pose
            self.model.update(self.now, seen)
            velocity = self.pace.next(wish, PERIOD, seen, poses, self.model)
            self.model.commanded = velocity
            self.velocities.append((self.x, velocity.linear_x))
            self._coming.append(velocity.linear_x)
            done = self._coming.popleft()
            if abs(done) >= self._dead_zone:
                self.x = min(self._wall, self.x + self._scale * done * PERIOD)
            self.now += PERIOD

    def fastest(self, nearer_than: float) -> float:
        """The highest speed that was commanded so near to the dock."""
        return max((speed for x, speed in self.velocities if x > -nearer_than), default=0.0)


def test_the_last_part_is_driven_slowly_whatever_is_wished() -> None:
    base = Base(0.7)
    base.drive(FAST, 8.0)
    assert base.x > 0.0
    assert base.fastest(RADIUS) == LIMITS.v_linear_min
    assert base.fastest(0.7) > 0.2


def test_a_base_that_stands_against_the_dock_has_no_dead_zone() -> None:
    base = Base(0.7, wall=-0.01)
    for _ in range(4):
        base.drive(FAST, 10.0)
        base.drive(Velocity(-0.15, 0.0), 3.0)
    assert base.fastest(RADIUS) == LIMITS.v_linear_min
    assert base.model.dead_zone.linear_x < LIMITS.v_linear_min


@pytest.mark.parametrize(("dead_zone", "at_dock"), [(0.05, 0.056), (0.058, 0.06)])
def test_a_base_with_a_dead_zone_drives_at_the_lowest_speed_that_moves_it(dead_zone: float, at_dock: float) -> None:
    base = Base(0.7, dead_zone=dead_zone, wall=-0.01)
    for _ in range(3):
        base.drive(FAST, 10.0)
        assert base.x == -0.01, "it gets there"
        base.drive(Velocity(-0.15, 0.0), 3.0)
    assert base.fastest(RADIUS) == pytest.approx(at_dock)


@pytest.mark.parametrize("dead_zone", [0.062, 0.07, 0.1])
def test_a_base_that_moves_only_faster_than_it_may_touch_its_dock_stops_before_it(dead_zone: float) -> None:
    base = Base(0.7, dead_zone=dead_zone, wall=-0.01)
    with pytest.raises(FailedToControl, match="set v_linear_min"):
        base.drive(FAST, 10.0)
    assert base.x < -0.9 * NEAR
    base.drive(Velocity(-0.15, 0.0), 3.0)
    assert base.x < -0.3, "it drives away as it did before"


def test_the_dead_zone_is_learned_before_the_robot_is_near() -> None:
    base = Base(0.7, dead_zone=0.05)
    base.drive(FAST, 1.0)
    assert max(speed for _, speed in base.velocities) == pytest.approx(0.056)
    assert base.x < -0.65
    base.drive(FAST, 3.0)
    assert base.model.sure_zone == pytest.approx(0.056)
    assert base.fastest(0.7) > 0.2, "and then it drives on"


@pytest.mark.parametrize("scale", [0.5, 3.0])
def test_a_base_that_is_not_to_scale_is_slow_for_its_first_moment_only(scale: float) -> None:
    base = Base(3.0, scale=scale)
    base.drive(FAST, 2.0)
    assert base.velocities[-1][1] == LIMITS.v_linear_max


def test_a_robot_that_stands_is_slow_until_it_moves() -> None:
    base = Base(2.0)
    base.drive(FAST, 2.0)
    base.frozen = base.pose
    base.drive(FAST, 1.0)
    assert {speed for _, speed in base.velocities[-10:]} == {LIMITS.v_linear_min}
    base.frozen = None
    base.drive(FAST, 1.0)
    assert base.velocities[-1][1] == LIMITS.v_linear_max


def test_odometry_that_stops_for_a_moment_is_no_dead_zone() -> None:
    base = Base(2.0)
    base.drive(FAST, 0.2)
    base.frozen = base.pose
    base.drive(FAST, 0.5)
    base.frozen = None
    base.drive(FAST, 1.0)
    assert base.model.dead_zone.linear_x == base.model.sure_zone == 0.0


@pytest.mark.parametrize("moment", [0.16, 0.12, 0.09, 0.07])
def test_it_counts_with_the_way_that_odometry_has_not_told(moment: float) -> None:
    """Odometry stops when the robot is so near."""
    base = Base(0.7, lag=0.1)
    while base.x < -moment:
        base.drive(FAST, PERIOD)
    base.frozen = base.pose
    base.drive(FAST, 0.5)
    base.frozen = None
    base.drive(FAST, 5.0)
    assert base.x > 0.0
    assert base.fastest(RADIUS) <= LIMITS.v_linear_min + 1e-6


def test_away_from_the_dock_it_may_be_fast() -> None:
    base = Base(0.0)
    base.drive(Velocity(-0.15, 0.0), 2.0)
    assert base.velocities[-1][1] == -0.15


def test_before_the_dock_is_known_only_the_limits_count() -> None:
    base = Base(0.05)
    base.drive(FAST, 1.0, KnownPoses())
    assert base.velocities[-1][1] == LIMITS.v_linear_max


def test_a_robot_that_is_too_fast_near_the_dock_stops_at_once() -> None:
    base = Base(0.5)
    base.drive(FAST, 2.0, KnownPoses())
    base.x = -0.05
    base.drive(FAST, PERIOD)
    assert base.velocities[-1][1] == 0.0


@settings(max_examples=200)
@given(
    st.lists(
        st.tuples(st.floats(-0.4, 0.4), st.floats(-2.0, 2.0), st.floats(0.0, 0.3), st.booleans(), st.booleans()),
        min_size=1,
        max_size=120,
    ),
    st.floats(-0.5, 0.02),
    st.floats(-0.2, 0.2),
)
def test_nothing_raises_the_speed_near_the_dock(
    steps: list[tuple[float, float, float, bool, bool]], x: float, y: float
) -> None:
    """Whatever is wished, at whatever times, and whatever odometry does then."""
    model, pace, now, last = MotionModel(), Pace(LIMITS, RADIUS), 0.0, STANDSTILL
    pose = DOCKED.compose(Pose(x, y))
    for linear, angular, dt, moves, rests in steps:
        now += dt
        if moves:
            pose = pose.compose(Pose(last.linear_x * dt, 0.0, last.angular_z * dt))
        model.update(now, pose)
        sure = model.sure_zone
        velocity = pace.stop() if rests else pace.next(Velocity(linear, angular), dt, pose, POSES, model)
        off = pose.relative_to(DOCKED)
        near, towards = abs(off.y) < 0.3 and off.x > -RADIUS, velocity.linear_x * math.cos(off.theta) > 0.0
        if near and towards:
            assert abs(velocity.linear_x) <= max(LIMITS.v_linear_min, sure) + 1e-6
        assert model.sure_zone <= model.moves_at
        assert abs(velocity.linear_x) <= LIMITS.v_linear_max
        if velocity != STANDSTILL:
            assert abs(velocity.linear_x - last.linear_x) <= LIMITS.a_linear_max * dt + 1e-9
        last = model.commanded = velocity


@pytest.mark.parametrize("heading", [2.5, -2.5])
def test_it_is_slow_in_front_of_the_dock_whichever_way_that_looks(heading: float) -> None:
    base = Base(1.0, docked=Pose(1.0, 0.5, heading))
    base.drive(FAST, 8.0, KnownPoses(base.docked, base.docked, base.docked.compose(Pose(-0.7))))
    assert base.fastest(nearer_than=1.0) > 0.15
    assert base.fastest(nearer_than=RADIUS) <= LIMITS.v_linear_min + 1e-9


def test_it_slows_down_on_the_same_arc() -> None:
    base = Base(0.05)
    base.drive(Velocity(0.26, 0.52), 0.3)
    assert base.model.commanded.linear_x == pytest.approx(0.04)
    assert base.model.commanded.angular_z == pytest.approx(0.08)


def test_a_robot_that_passes_beside_the_dock_may_be_fast() -> None:
    base = Base(1.5)
    base.drive(FAST, 2.0)
    fast = base.model.commanded
    assert fast.linear_x == pytest.approx(0.26)
    base.frozen = DOCKED.compose(Pose(-0.05, 2.0))
    base.drive(FAST, PERIOD)
    assert base.model.commanded == fast


@pytest.mark.parametrize("stopped", [True, False], ids=["stopped", "slowed down to a standstill"])
def test_a_base_that_needs_more_than_the_slowest_speed_is_tested_again_at_each_start(stopped: bool) -> None:
    base = Base(4.0, dead_zone=0.06)
    base.drive(FAST, 3.0)
    assert base.model.moves_at > LIMITS.v_linear_min
    if stopped:
        base.model.commanded = base.pace.stop()
    base.drive(STANDSTILL, 1.5)
    base.drive(FAST, 3 * PERIOD)
    assert base.model.commanded.linear_x == pytest.approx(LIMITS.v_linear_min)


WISHES = st.builds(Velocity, st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))


@given(st.lists(st.tuples(WISHES, st.floats(0.0, 0.5)), max_size=40))
def test_velocity_and_acceleration_stay_within_their_limits(wishes: list[tuple[Velocity, float]]) -> None:
    limiter, last = Limiter(LIMITS), STANDSTILL
    for wish, dt in wishes:
        velocity = limiter.limit(wish, dt)
        assert abs(velocity.linear_x) <= 0.26
        assert abs(velocity.angular_z) <= 1.0
        assert abs(velocity.linear_x - last.linear_x) <= 0.5 * dt + 1e-9
        assert abs(velocity.angular_z - last.angular_z) <= 2.0 * dt + 1e-9
        last = velocity


def test_a_wish_within_the_limits_is_granted_in_the_end() -> None:
    limiter, wish = Limiter(LIMITS), Velocity(-0.2, 0.7)
    velocities = [limiter.limit(wish, 0.1) for _ in range(10)]
    assert velocities[-1] == wish
    assert math.isclose(velocities[0].linear_x, -0.05)


def test_a_stop_is_not_delayed() -> None:
    limiter = Limiter(LIMITS)
    for _ in range(20):
        limiter.limit(Velocity(0.26, 1.0), 0.1)
    assert limiter.stop() == STANDSTILL
    assert limiter.limit(STANDSTILL, 0.1) == STANDSTILL


@pytest.mark.parametrize(("wish", "expected"), [(0.02, 0.05), (-0.01, -0.05), (0.0, 0.0), (0.1, 0.1)])
def test_it_drives_at_its_slowest_or_not_at_all(wish: float, expected: float) -> None:
    limiter = Limiter(LIMITS)
    velocities = [limiter.limit(Velocity(wish, 0.0), 0.05, Velocity(0.05, 0.0)) for _ in range(20)]
    assert velocities[-1].linear_x == expected


@given(st.floats(-0.2, 0.2), st.floats(0.02, 0.1))
def test_a_slow_turn_is_made_of_faster_ones_and_the_mean_is_right(wish: float, dt: float) -> None:
    limiter, turned = Limiter(LIMITS), 0.0
    for _ in range(600):
        turned += dt * limiter.limit(Velocity(0.1, wish), dt, Velocity(0.0, 0.15)).angular_z
    assert turned == pytest.approx(600 * dt * wish, abs=0.1)


def test_a_turn_that_is_fast_enough_owes_nothing() -> None:
    limiter = Limiter(MotionLimits(v_angular_min=0.3))
    for _ in range(20):
        limiter.limit(Velocity(0.0, 0.3), 0.05)
    assert [limiter.limit(STANDSTILL, 0.2) for _ in range(3)] == [STANDSTILL] * 3


def test_a_stop_forgets_the_turn_that_was_owed() -> None:
    limiter = Limiter(LIMITS)
    limiter.limit(Velocity(0.0, 0.14), 0.2, Velocity(0.0, 0.15))
    limiter.stop()
    assert [limiter.limit(STANDSTILL, 0.1, Velocity(0.0, 0.15)) for _ in range(5)] == [STANDSTILL] * 5
