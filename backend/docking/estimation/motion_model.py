"""Learns from odometry how the base carries out commands: how late, and from which velocity on.

Everything that depends on it has one model: the controllers plan from where the robot will be when the next command
takes effect (a Smith predictor), and a base that does not move as commanded is recognized.
"""

import math

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Deceleration, Velocity
from docking.estimation.braking import Braking
from docking.estimation.motion_history import NOWHERE, WINDOW, Motion, MotionHistory

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


class MotionModel:
    """Compares commands with odometry.

    Attributes:
        commanded: The velocity since the last step.
        history: The motion of the last seconds.
        lag: Seconds from a command until odometry shows the motion.
        dead_zone: Learned dead zone: smaller commands do not move the base.
        moves_at: The lowest speed that was commanded and driven, in m/s; infinite before.
        sure_zone: The confirmed part of the dead zone, in m/s: the base was seen to drive beyond it.
        learns: Whether a base that does not move may have a dead zone; else something is in its way.
        tried_first: A speed, in m/s, that is commanded before a higher one while the dead zone is learned.
        stands: Whether the base, commanded to drive, did not for longer than it may take to begin, and has not since.
        braking: How fast the base slows down, forward or backward.
        turn_braking: The same of turns.
    """

    def __init__(self, memory: float = 2.0) -> None:
        """Start at a standstill.

        Args:
            memory: Seconds of history that are kept at least, beyond the largest lag.
        """
        self.commanded = STANDSTILL
        self.history = MotionHistory(memory + LAGS[-1])
        self.lag = USUAL_LAG
        self.dead_zone = STANDSTILL
        self.moves_at = math.inf
        self.sure_zone = 0.0
        self.stands = False
        self.learns = True
        self.tried_first = math.inf
        self.braking, self.turn_braking = Braking(AT_REST, 0.1), Braking(TURNED, 0.4)
        self._errors = [0.0] * len(LAGS)
        self._still_since = [math.inf, math.inf]
        self._raised_at = [-math.inf, -math.inf]
        self._stood_since = [math.inf, math.inf]  # rests do not count
        self._zone_before = [0.0, 0.0]  # when it came to stand
        self._held = 0.0  # a steady command to drive
        self._fastest = 0.0  # command since the base stood
        self._moves = False  # forward or backward, ever
        self._obeys_since = math.inf

    def elapse(self, now: float) -> None:
        """Let time pass; `commanded` applied since the last step, whether odometry says anything or not."""
        self.history.command(now, self.commanded)

    def update(self, now: float, pose: Pose) -> None:
        """Update with odometry; `commanded` applied since the last step."""
        history = self.history
        if history.add(now, pose, self.commanded):
            self._learn_lag()
            self._learn_dead_zone(now)
            velocity = history.velocity
            self.braking.add(now, velocity.linear_x, self.commanded.linear_x)
            self.turn_braking.add(now, velocity.angular_z, self.commanded.angular_z)
        elif history.known_since == now:
            self._still_since = [math.inf, math.inf]
            self._stood_since = [math.inf, math.inf]
            self._obeys_since = math.inf
            self.stands = False

    # Derived values.

    @property
    def deceleration(self) -> Deceleration:
        """The greatest deceleration of the base, where that is less than commanded."""
        return Deceleration(self.braking.limit, self.turn_braking.limit)

    @property
    def unseen(self) -> Motion:
        """The motion that was commanded since odometry last changed, and may have been carried out."""
        return self.history.commands(self.history.changed_at - self.lag, self.history.now)

    def expected(self, begin: float, end: float) -> Motion:
        """The motion that there must have been between two moments, by the commands, where nothing is in the way."""
        return self.history.commands(begin - self.lag, min(end, self.history.now) - self.lag)

    def possible(self, now: float) -> Motion:
        """All that may have been carried out since odometry measured another pose, however late the base is."""
        history = self.history
        if history.last is None:
            return NOWHERE
        self.elapse(now)
        return history.commands(history.changed_at - LAGS[-1], history.now).then(history.coming)

    def ahead(self, pose: Pose) -> Pose:
        """Return where the robot will be when a command that is given now takes effect.

        Args:
            pose: The newest that odometry has measured.
        """
        if self.history.last is None:
            return pose
        now = self.history.now
        coming = self.history.commands(now - self.lag, now)
        # A base that does not move at all is not about to.
        way, turn = (
            0.0 if now - since > self.lag + WINDOW else motion
            for motion, since in zip((coming.way, coming.turn), self._still_since, strict=True)
        )
        half = 0.5 * turn
        return pose.compose(Pose(way * math.cos(half), way * math.sin(half), turn))

    # How it learns.

    def _learn_lag(self) -> None:
        now = self.history.now
        began, _, moved = self.history.last_step()
        steps = []
        for lag in LAGS:
            step = self.history.commands(began - lag, now - lag)
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
        began, commanded, measured = self.history.last_step()
        dt, told = now - began, self.commanded
        if not (_same(commanded.way, told.linear_x * dt) and _same(commanded.turn, told.angular_z * dt)):
            return  # the command has changed since: what was measured is of both
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
        """Return the speed to command after one that did not move the base."""
        raised = RAISE * speed
        return self.tried_first if axis == 0 and speed < self.tried_first < raised else raised

    def _obeys(self, command: float, began: float) -> bool:
        """Whether the base drives by one command, as measured over a moment.

        Where it was commanded to be faster before, it may be about to stop; a base that begins is only not to scale.
        """
        commanded = self.commanded.linear_x
        if commanded == 0.0 and abs(self.history.velocity.linear_x) < AT_REST:
            self._fastest = 0.0
        self._fastest = max(self._fastest, abs(commanded))
        most = OBEYED[1] if self._fastest > (1.0 + STEADY) * abs(commanded) else math.inf
        steady = abs(commanded - self._held) <= STEADY * abs(commanded)
        if not steady or command == 0.0:
            self._held = commanded
        elif OBEYED[0] <= self.history.velocity.linear_x / commanded <= most:
            self._obeys_since = min(self._obeys_since, began)
            return True
        self._obeys_since = math.inf
        return False

    def _moved_unseen(self, axis: int) -> bool:
        """Whether a base that seemed to stand moves on from where it would be had it moved all the time."""
        since, now = self._stood_since[axis], self.history.now
        if since == math.inf:
            return False
        measured, commanded = self.history.measured(since, now), self.history.commands(since, now)
        if axis == 0:
            return abs(measured.way) > 0.5 * abs(commanded.way)
        return abs(measured.turn) > 0.5 * abs(commanded.turn)


def _same(one: float, other: float) -> bool:
    """Whether two ways or turns are the same, but for rounding."""
    return math.isclose(one, other, rel_tol=1e-6, abs_tol=1e-9)
