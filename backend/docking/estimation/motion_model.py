"""How the base carries out commands, learned from odometry: how late, and from which velocity on.

Everything that depends on it has one model: the controllers plan from where the robot will be when the next command
takes effect (a Smith predictor), and a base that does not move as commanded is recognized.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Deceleration, Velocity
from docking.estimation.braking import Braking

LAGS = tuple(0.05 * number for number in range(13))
"""Candidates for the lag, in s: the time from a command until odometry shows the motion."""
USUAL_LAG = 0.05
"""In s; assumed until the lag is learned."""
DOUBT = 1e-3
"""How much an unusual lag must explain better, in m² for each s² that it is away from the usual one."""
LEVER = 0.15
"""How many m of error one rad of error counts as."""
FORGETTING = 0.99
"""The weight of a step in the next one."""
PAUSE = 0.4
"""In s; after a longer time without a look, the motion is unknown: a base stops when commands stay away."""
WINDOW = 0.15
"""Seconds over which a velocity is measured."""
STUCK = 0.3
"""Seconds without motion after which a command is too small for the base."""
STILL = 0.1
"""The part of a commanded motion below which there is none."""
AT_ONCE = 0.005
"""In m or rad; odometry that moves by more in one step has moved, also while the base is to stand."""
RAISE = 1.4
"""How much larger than a command that did not move the base the next one must be."""
STEADY = 0.1
"""How much a command may change and still be taken for the same, as a part of it."""
AT_REST = 0.02
"""In m/s: a base that is slower has come to a standstill."""
TURNED = 0.05
"""In rad/s; the same of a base that turns."""
OBEYED = (0.3, 1.5)
"""The part of a steady command that is measured where the base moves by it, and is not about to stop from more."""
OBEYED_FOR = 0.3
"""Seconds for which the base must do so, beyond the lag."""
DEAD_ZONE_MAX = Velocity(0.12, 0.4)
"""The largest dead zone that is learned: a base that does not move then is blocked."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Ways from the start on.

    Attributes:
        way: Forward, in m.
        turn: To the left, in rad.
        to_and_fro: Forward and backward, in m.
        turn_to_and_fro: To the left and to the right, in rad.
    """

    way: float = 0.0
    turn: float = 0.0
    to_and_fro: float = 0.0
    turn_to_and_fro: float = 0.0

    def plus(self, way: float, turn: float) -> "Motion":
        """The motion with one more step."""
        return Motion(self.way + way, self.turn + turn, self.to_and_fro + abs(way), self.turn_to_and_fro + abs(turn))

    def since(self, before: "Motion") -> "Motion":
        """The motion from `before` to now."""
        return Motion(
            self.way - before.way,
            self.turn - before.turn,
            self.to_and_fro - before.to_and_fro,
            self.turn_to_and_fro - before.turn_to_and_fro,
        )

    def towards(self, after: "Motion", share: float) -> "Motion":
        """The motion at a share of the way to `after`: a linear interpolation."""
        return Motion(
            self.way + share * (after.way - self.way),
            self.turn + share * (after.turn - self.turn),
            self.to_and_fro + share * (after.to_and_fro - self.to_and_fro),
            self.turn_to_and_fro + share * (after.turn_to_and_fro - self.turn_to_and_fro),
        )


NOWHERE = Motion()


class MotionModel:
    """Compares commands with odometry.

    Attributes:
        commanded: The velocity since the last look.
        lag: Seconds from a command until odometry shows the motion.
        dead_zone: Learned dead zone: smaller commands do not move the base.
        moves_at: The lowest speed that was commanded and driven, in m/s; infinite before.
        sure_zone: The dead zone, in m/s, as far as it is confirmed by a base that was seen to drive beyond it.
        learns: Whether a base that does not move may have a dead zone; else something is in its way.
        tried_first: A speed, in m/s, that is commanded before a higher one while the dead zone is learned.
        stands: Whether the base, commanded to drive, did not for longer than it may take to begin, and has not since.
        known_since: Since when there was no pause, in s.
        braking: How fast the base slows down, forward or backward.
        turn_braking: The same of turns.
    """

    def __init__(self, memory: float = 2.0) -> None:
        """Start at a standstill.

        Args:
            memory: Seconds of history that are kept at least, beyond the largest lag.
        """
        self.commanded = STANDSTILL
        self.known_since = math.inf
        self._memory = memory + LAGS[-1]
        self.lag = USUAL_LAG
        self.dead_zone = STANDSTILL
        self.moves_at = math.inf
        self.sure_zone = 0.0
        self.stands = False
        self.learns = True
        self.tried_first = math.inf
        self.braking, self.turn_braking = Braking(AT_REST, 0.1), Braking(TURNED, 0.4)
        self._changed_at = -math.inf
        self._times: list[float] = []
        self._commands: list[Motion] = []
        self._measured: list[Motion] = []
        self._last: Pose | None = None
        self._lagged = [NOWHERE] * len(LAGS)
        self._errors = [0.0] * len(LAGS)
        self._still_since = [math.inf, math.inf]
        self._raised_at = [-math.inf, -math.inf]
        self._stood_since = [math.inf, math.inf]  # rests do not count
        self._zone_before = [0.0, 0.0]  # when it came to stand
        self._held = 0.0  # a steady command to drive
        self._fastest = 0.0  # command since the base stood
        self._moves = False  # forward or backward, ever
        self._obeys_since = math.inf

    # History.

    def look(self, now: float, pose: Pose) -> None:
        """Update with odometry; `commanded` applied since the last look."""
        last, self._last = self._last, pose
        if pose != last:
            self._changed_at = now
        dt = now - self._times[-1] if self._times else math.inf
        if last is None or dt > PAUSE:
            self._times, self._commands, self._measured = [now], [NOWHERE], [NOWHERE]
            self._lagged = [NOWHERE] * len(LAGS)
            self._still_since = [math.inf, math.inf]
            self._stood_since = [math.inf, math.inf]
            self._obeys_since = math.inf
            self.stands = False
            self.known_since = now
            return
        if dt <= 0.0:
            return
        moved = pose.relative_to(last)
        self._times.append(now)
        self._commands.append(self._commands[-1].plus(self.commanded.linear_x * dt, self.commanded.angular_z * dt))
        self._measured.append(self._measured[-1].plus(moved.x, moved.theta))
        if self._times[0] < now - 2.0 * self._memory:
            gone = bisect_right(self._times, now - self._memory)
            del self._times[:gone], self._commands[:gone], self._measured[:gone]
        self._learn_lag()
        self._learn_dead_zone(now)
        velocity = self.velocity
        self.braking.look(now, velocity.linear_x, self.commanded.linear_x)
        self.turn_braking.look(now, velocity.angular_z, self.commanded.angular_z)

    def commands(self, begin: float, end: float) -> Motion:
        """The motion that was commanded between two moments."""
        return self._at(self._commands, end).since(self._at(self._commands, begin))

    def measured(self, begin: float, end: float) -> Motion:
        """The motion that odometry measured between two moments."""
        return self._at(self._measured, end).since(self._at(self._measured, begin))

    def _at(self, history: list[Motion], at: float) -> Motion:
        times = self._times
        index = bisect_right(times, at)
        if index == 0:
            return history[0]
        if index == len(times):
            return history[-1]
        before, after = times[index - 1], times[index]
        return history[index - 1].towards(history[index], (at - before) / (after - before))

    # Derived values.

    @property
    def velocity(self) -> Velocity:
        """The measured velocity: from poses, since not every odometry has a velocity."""
        if len(self._times) < 2:
            return STANDSTILL
        now = self._times[-1]
        seconds = min(WINDOW, now - self._times[0])
        moved = self.measured(now - seconds, now)
        return Velocity(moved.way / seconds, moved.turn / seconds)

    @property
    def deceleration(self) -> Deceleration:
        """How fast the base slows down at most, where it is weaker than commanded."""
        return Deceleration(self.braking.limit, self.turn_braking.limit)

    @property
    def last(self) -> Pose | None:
        """The pose of the last look."""
        return self._last

    @property
    def unseen(self) -> Motion:
        """The motion that was commanded since odometry last changed, and may have been carried out."""
        if not self._times:
            return NOWHERE
        return self.commands(self._changed_at - self.lag, self._times[-1])

    def expected(self, begin: float, end: float) -> Motion:
        """The motion that there must have been between two moments, by the commands, where nothing is in the way."""
        return self.commands(begin - self.lag, min(end, self._times[-1]) - self.lag) if self._times else NOWHERE

    def possible(self, now: float) -> Motion:
        """All that may have been carried out since odometry measured another pose, however late the base is."""
        if not self._times:
            return NOWHERE
        dt = now - self._times[-1]
        before = self.commands(self._changed_at - LAGS[-1], self._times[-1])
        return before.plus(self.commanded.linear_x * dt, self.commanded.angular_z * dt)

    def velocity_at(self, moment: float) -> Velocity:
        """The velocity at a moment, measured over `WINDOW` before it."""
        if not self._times:
            return STANDSTILL
        moved = self.measured(moment - WINDOW, moment)
        return Velocity(moved.way / WINDOW, moved.turn / WINDOW)

    def ahead(self, pose: Pose) -> Pose:
        """Where the robot will be when a command that is given now takes effect.

        Args:
            pose: The newest that odometry has measured.
        """
        if not self._times:
            return pose
        now = self._times[-1]
        coming = self.commands(now - self.lag, now)
        # A base that does not move at all is not about to.
        way, turn = (
            0.0 if now - since > self.lag + WINDOW else motion
            for motion, since in zip((coming.way, coming.turn), self._still_since, strict=True)
        )
        half = 0.5 * turn
        return pose.compose(Pose(way * math.cos(half), way * math.sin(half), turn))

    # How it learns.

    def _learn_lag(self) -> None:
        now = self._times[-1]
        moved = self._measured[-1].since(self._measured[-2])
        steps = []
        for number, lag in enumerate(LAGS):
            before, self._lagged[number] = self._lagged[number], self._at(self._commands, now - lag)
            step = self._lagged[number].since(before)
            steps.append((step.way - moved.way) ** 2 + (LEVER * (step.turn - moved.turn)) ** 2)
        if max(steps) - min(steps) < 1e-9:
            return
        self._errors = [FORGETTING * error + step for error, step in zip(self._errors, steps, strict=True)]
        scores = [error + DOUBT * (lag - USUAL_LAG) ** 2 for error, lag in zip(self._errors, LAGS, strict=True)]
        best = min(range(len(LAGS)), key=scores.__getitem__)
        self.lag = LAGS[best]
        if 0 < best < len(LAGS) - 1:  # between the two neighbours, by a parabola
            less, least, more = scores[best - 1 : best + 2]
            self.lag += 0.5 * (LAGS[1] - LAGS[0]) * (less - more) / (less - 2.0 * least + more)

    def relearn(self) -> None:
        """Find out again from which velocity on the base drives: what was in its way before may be gone."""
        self.moves_at, self.sure_zone, self._zone_before[0] = math.inf, 0.0, 0.0
        self.dead_zone = Velocity(0.0, self.dead_zone.angular_z)

    def forget_stand(self) -> None:
        """The base stands since something is in its way: that is no dead zone."""
        self.dead_zone = Velocity(self.sure_zone, self.dead_zone.angular_z)
        self._still_since[0] = self._stood_since[0] = math.inf
        self.stands = False

    def _learn_dead_zone(self, now: float) -> None:
        commanded, measured = self._commands[-1].since(self._commands[-2]), self._measured[-1].since(self._measured[-2])
        began = self._times[-2]
        zone = [self.dead_zone.linear_x, self.dead_zone.angular_z]
        most = (DEAD_ZONE_MAX.linear_x, DEAD_ZONE_MAX.angular_z)
        speeds = (abs(self.commanded.linear_x), abs(self.commanded.angular_z))
        if self._obeys(commanded.way, began) and now - self._obeys_since > OBEYED_FOR + self.lag:
            self.moves_at = min(self.moves_at, speeds[0])
            self.sure_zone = self._zone_before[0] = zone[0] = min(zone[0], self.moves_at)
        for axis, (command, way) in enumerate(((commanded.way, measured.way), (commanded.turn, measured.turn))):
            if command == 0.0 or abs(way) > STILL * abs(command):
                self._still_since[axis] = math.inf
                if command != 0.0 or abs(way) > AT_ONCE:
                    if self._moved_unseen(axis):
                        zone[axis] = self._zone_before[axis]
                    self._stood_since[axis] = math.inf
                    self.stands = self.stands and axis == 1
                    self._moves |= axis == 0
                continue
            self._still_since[axis] = min(self._still_since[axis], began)
            if self._stood_since[axis] == math.inf:
                self._stood_since[axis], self._zone_before[axis] = began, zone[axis]
            self.stands |= axis == 0 and now - self._still_since[0] > STUCK + self.lag
            stood_for = now - max(self._still_since[axis], self._raised_at[axis])
            # Before the base has ever moved, its lag is unknown.
            late = STUCK + self.lag if self._moves or axis == 1 or zone[0] > 0.0 else LAGS[-1]
            if self.learns and stood_for > late and (axis == 1 or speeds[0] < self.moves_at):
                zone[axis] = min(most[axis], max(zone[axis], self._raised(axis, speeds[axis])))
                self._raised_at[axis] = now
        self.dead_zone = Velocity(min(zone[0], self.moves_at), zone[1])

    def _raised(self, axis: int, speed: float) -> float:
        """What is commanded after a speed that did not move the base."""
        raised = RAISE * speed
        return self.tried_first if axis == 0 and speed < self.tried_first < raised else raised

    def _obeys(self, command: float, began: float) -> bool:
        """Whether the base drives by one command, as measured over a moment.

        Where it was commanded to be faster before, it may be about to stop; a base that begins is only not to scale.
        """
        commanded = self.commanded.linear_x
        if commanded == 0.0 and abs(self.velocity.linear_x) < AT_REST:
            self._fastest = 0.0
        self._fastest = max(self._fastest, abs(commanded))
        most = OBEYED[1] if self._fastest > (1.0 + STEADY) * abs(commanded) else math.inf
        steady = abs(commanded - self._held) <= STEADY * abs(commanded)
        if not steady or command == 0.0:
            self._held = commanded
        elif OBEYED[0] <= self.velocity.linear_x / commanded <= most:
            self._obeys_since = min(self._obeys_since, began)
            return True
        self._obeys_since = math.inf
        return False

    def _moved_unseen(self, axis: int) -> bool:
        """Whether a base that seemed to stand moves on from where it would be had it moved all the time."""
        since, now = self._stood_since[axis], self._times[-1]
        if since == math.inf:
            return False
        measured, commanded = self.measured(since, now), self.commands(since, now)
        if axis == 0:
            return abs(measured.way) > 0.5 * abs(commanded.way)
        return abs(measured.turn) > 0.5 * abs(commanded.turn)
