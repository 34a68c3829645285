"""A goal from its acceptance to its end: a state machine that is stepped with the time and the sensor readings."""

from dataclasses import replace

from docking.core.errors import Blocked, DockingError, ErrorCode, FailedToControl, OdometryJumped, Stage
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.battery_watch import CLOCK_JUMP, BatteryWatch
from docking.goal.behavior import Behavior, Done, Failed
from docking.goal.detector import Detector
from docking.goal.doubts import Doubts
from docking.goal.hits import describe
from docking.goal.motion_watch import MotionWatch
from docking.goal.navigation import Going, Navigation
from docking.goal.objective import Objective, Progress
from docking.goal.obstacle_watch import ObstacleWatch
from docking.goal.outcome import Command, End, Outcome
from docking.goal.pace import Pace
from docking.goal.plan import DockTarget, Plan, RecoveringPlan
from docking.goal.recovery import Recovery
from docking.goal.time_limits import TimeLimits


class Goal:
    """One accepted goal. It has one outcome, the first; whatever comes later changes nothing.

    The plan says what moves the robot at each stage, the objective when the goal is reached. Here is what all goals
    have in common: nothing moves while the battery or odometry is silent, time runs out, velocities keep the limits,
    and what fails is tried again.

    Attributes:
        outcome: None while the goal goes on.
        doubts: What seemed wrong on the way; the final error names it.
    """

    def __init__(
        self, plan: Plan, objective: Objective, started_at: float, obstacles: ObstacleWatch | None = None
    ) -> None:
        """Start the goal.

        Args:
            plan: The stages and what moves the robot at each.
            objective: The objective of the goal.
            started_at: Seconds of the clock that observations have.
            obstacles: Collision detection; None without it.
        """
        self.outcome: Outcome | None = None
        self.doubts = plan.doubts if isinstance(plan, DockTarget) else Doubts()
        self._plan = plan
        self._objective = objective
        self._obstacles = obstacles if plan.motion is not None else None
        self._timeouts = objective.timeouts
        self._started_at = self._stepped_at = started_at
        self._battery = BatteryWatch(objective.timeouts, started_at)
        self._pace: Pace | None = None
        self._watch: MotionWatch | None = None
        if plan.motion is not None:
            objective.memory.hits.forget(started_at)
            self._pace = Pace(plan.motion, objective.slowdown_radius, objective.memory.hits)
            self._watch = MotionWatch(self._timeouts.odometry_timeout, self._timeouts.blocked_after, started_at)
        self._navigation: Navigation | None = None
        self._detector: Detector | None = None
        self._recovery = Recovery(plan, objective, self.doubts)
        self._limits = TimeLimits(plan, objective, 0.0 if self._obstacles is None else self._obstacles.timeout)
        self._enter(plan.stages[0])

    @property
    def retries(self) -> int:
        """Number of retries."""
        return self._recovery.retries

    @property
    def longest(self) -> float:
        """Seconds after which the goal has ended, whatever happens; infinite where nothing limits it."""
        before = sum(first.timeout for first in (self._navigation, self._detector) if first is not None)
        return self._limits.longest(before)

    def navigate_first(self, navigation: Navigation) -> None:
        """Have the robot driven to its staging pose before the plan begins; call it before the first step."""
        self._navigation = navigation

    def detect_with(self, detector: Detector) -> None:
        """Have the detector of the marker switched on before the plan begins; call it before the first step."""
        self._detector = detector

    def was_commanded(self, velocity: Velocity) -> None:
        """Note that the robot follows another velocity than that of the last step, as in a replay."""
        if self._watch is not None:
            self._watch.commanded = velocity

    # A step: is the goal reached, is the battery heard, and what moves the robot?

    def step(self, observation: Observation) -> Command | Outcome:
        """Step the goal: return the next command, or the outcome.

        Only a battery reading that is not stale can end the goal well: one from before the goal counts as long as it
        is fresh. Where the clock jumps back, nothing tells how old anything is any more, so that the goal is aborted.

        Args:
            observation: Current sensor readings.
        """
        if self.outcome is not None:
            return self.outcome
        now, timeouts = observation.now, self._timeouts
        dt, self._stepped_at = now - self._stepped_at, now
        if dt < -CLOCK_JUMP:
            return self._give_up(ErrorCode.UNKNOWN, f"the clock jumped back by {-dt:.3g} s")
        dt = max(0.0, dt)
        self._limits.elapse(dt)
        if self._watch is not None:
            self._watch.elapse(now)
        fresh = self._battery.fresh(observation.battery, now)
        try:
            reached = self._objective.is_reached(observation, fresh, self._progress)
        except DockingError as failure:
            return self.abort(failure.error_code, str(failure))
        if self._objective.doubt:
            self.doubts.note("charge", self._objective.doubt)
        if self._objective.unsure:
            self.doubts.note("docked", self._objective.unsure)
        if reached:
            return self._succeed(observation)
        if 0.0 < timeouts.goal_timeout <= now - self._started_at:
            return self._give_up(
                ErrorCode.TIMEOUT, f"the goal was not reached within {timeouts.goal_timeout:g} s (goal_timeout)"
            )
        waits = fresh is None and self._objective.needs_battery
        return self._wait_for_battery(observation, dt) if waits else self._go_on(observation, dt)

    @property
    def _progress(self) -> Progress:
        poses = self._plan.poses
        at_last = self._stage is self._plan.stages[-1]
        return Progress(at_last, self._finished, poses.filtered_dock, poses.turn, poses.camera)

    def _wait_for_battery(self, observation: Observation, dt: float) -> Command | Outcome:
        if lost := self._battery.describe_loss(observation.now):
            return self._give_up(ErrorCode.BATTERY_LOST, lost)
        silence = self._battery.describe_silence(observation.battery, observation.now)
        return self._wait(Stage.WAIT_FOR_BATTERY, ErrorCode.BATTERY_STALE, silence, dt)

    def _go_on(self, observation: Observation, dt: float) -> Command | Outcome:
        """The battery charges, another server drives to the staging pose, or the plan drives."""
        if self._objective.holds(self._stage):
            self._limits.count(dt if self._objective.flickers else 0.0)
            return self._command(self._rest(), Stage.WAIT_FOR_CHARGE)
        if self._navigation is not None:
            return self._navigate(self._navigation, observation, dt)
        return self._follow_plan(observation, dt)

    def _navigate(self, navigation: Navigation, observation: Observation, dt: float) -> Command | Outcome:
        """Leave the wheels to the server that drives to the staging pose; then the plan begins."""
        try:
            if self._watch is not None and self._watch.hears(observation) is None and self._watch.waiting:
                return self._wait(Stage.WAIT_FOR_ODOMETRY, ErrorCode.ODOMETRY_LOST, self._watch.waiting, dt)
            going = navigation.step(dt)
        except DockingError as failure:
            return self.abort(failure.error_code, str(failure))
        if going is Going.DRIVES:
            self._objective.memory.moves()
            return replace(self._command(STANDSTILL, Stage.NAV_TO_STAGING_POSE), yields=True)
        if going is Going.WAITS:
            return self._command(self._rest(), Stage.NAV_TO_STAGING_POSE)
        self._navigation = None
        self._enter(self._plan.stages[0])
        return self._command(self._rest())

    def _follow_plan(self, observation: Observation, dt: float) -> Command | Outcome:
        """Odometry tells where the robot is, the plan where the dock is, and the way is clear: the controller drives.

        The time limits of stages are for driving: while the robot waits, their time stands still.
        """
        watch, obstacles = self._watch, self._obstacles
        try:
            if watch is not None and self._plan.poses.pushes:
                watch.restart()
            if watch is not None and not watch.sees(observation):
                return self._wait(Stage.WAIT_FOR_ODOMETRY, ErrorCode.ODOMETRY_LOST, watch.waiting, dt)
            if self._detector is not None:
                if not self._detector.is_on(dt):
                    return self._command(self._rest())
                self._detector = None
            if doubt := self._observe(observation):
                return self._wait(self._stage, self._plan.lost.error_code, f"{doubt}: the robot waits", dt)
            # Where the robot will be when a command that is given now takes effect.
            ahead = observation if watch is None else watch.ahead(observation)
            if obstacles is not None and not obstacles.check(ahead, self._plan.poses.filtered_dock, dt):
                code = ErrorCode.SCAN_LOST if obstacles.lost else ErrorCode.OBSTRUCTED
                return self._wait(Stage.WAIT_FOR_CLEARANCE, code, obstacles.reason, dt)
            velocity = self._move(observation, ahead, dt)
        except DockingError as failure:
            return self._recover(self._objective.reword(failure), observation)
        if watch is not None:
            watch.commanded = velocity
        if velocity != STANDSTILL:
            self._objective.memory.moves()
        return self._command(velocity)

    def _observe(self, observation: Observation) -> str:
        """Let the plan take notice; return why the robot must not move, as a sentence, empty if it may.

        Raises:
            DockingError: What is seen cannot be.
        """
        self._plan.observe(observation)
        poses = self._plan.poses
        if poses.note:
            self.doubts.note("marker", poses.note)
        return poses.doubt

    def _move(self, observation: Observation, ahead: Observation, dt: float) -> Velocity:
        """Let the controller say what to do, and keep the limits.

        Raises:
            DockingError: It fails, says nothing sensible, or has taken too long.
        """
        self._limits.count(dt, searches=self._plan.poses.explores and self._stage is self._plan.stages[0])
        if (too_long := self._limits.exceeded(self._stage, finished=self._finished)) is not None:
            raise too_long
        if self._finished:
            return self._rest()
        step = self._controller.step(ahead, dt)
        if isinstance(step, Failed):
            raise step.error
        if isinstance(step, Done):
            self._next_stage()
            return self._rest()
        if not step.finite:
            raise FailedToControl(f"the controller gave {step}")
        if self._pace is None or self._watch is None or observation.odometry is None:
            return step
        desired = step if self._obstacles is None else self._obstacles.slow_down(step)
        backwards, obstacles = desired.linear_x < 0.0, self._obstacles
        sees = obstacles is not None and (obstacles.sees_behind or not backwards)
        robot, poses, model = observation.odometry.pose, self._plan.poses, self._watch.model
        velocity = self._pace.next(
            desired,
            dt,
            robot,
            poses,
            model,
            sees_behind=sees and backwards,
            slowly=bool(self._objective.unsure) and not sees,
        )
        return self._rest() if self._obstacles is not None and self._obstacles.stops(velocity) else velocity

    # A stage is done, or something has failed.

    def _next_stage(self) -> None:
        stages, reason = self._plan.stages, self._recovery.reason
        if self._stage is Stage.RETURN_TO_STAGING and reason is not None:
            self.abort(reason.error_code, str(reason))
        elif self._stage in {Stage.RETRY, Stage.CORRECTING}:
            self._recovery.over()
            self._enter(stages[0] if self._stage is Stage.RETRY else stages[-1])
        elif self._stage is stages[-1]:
            self._finished = True
        else:
            self._enter(stages[stages.index(self._stage) + 1])

    def _recover(self, failure: DockingError, observation: Observation) -> Command | Outcome:
        """Try again where that may help, else give up."""
        hit = isinstance(failure, Blocked) and not isinstance(failure, OdometryJumped)
        if hit and observation.odometry is not None:
            self._objective.memory.hits.add(observation.odometry.pose, observation.now)
            self.doubts.count("hit", describe(observation.odometry.pose, self._plan.poses.filtered_dock))
        last = self._plan.stages[-1]
        if self._stage is not last and self._objective.holds(last):  # pressing on, it has come as far as it can get
            self._enter(last)
            return self._command(self._rest())
        after = self._recovery.after(failure, self._stage)
        if isinstance(after, DockingError):
            return self.abort(after.error_code, str(after))
        self._enter(after)
        return self._command(self._rest())

    def _enter(self, stage: Stage) -> None:
        self._stage = stage
        self._limits.enter()
        self._finished = False
        self._controller: Behavior = self._behavior(stage)
        if self._watch is not None:
            self._watch.restart()

    def _behavior(self, stage: Stage) -> Behavior:
        """Return a new behavior that moves the robot at a stage."""
        plan = self._plan
        if stage is Stage.CORRECTING and isinstance(plan, RecoveringPlan):
            return plan.correct(self._recovery.corrections)
        if stage is Stage.RETURN_TO_STAGING and isinstance(plan, RecoveringPlan):
            return plan.way_back()
        return plan.controller(stage)

    # The goal ends.

    def _succeed(self, observation: Observation) -> Outcome:
        odometry = observation.odometry
        self._objective.memory.note(self._objective.docks, None if odometry is None else odometry.pose, observation.now)
        return self._finish(Outcome(End.SUCCEEDED, retries=self.retries, doubts=self.doubts.sentences()))

    def cancel(self) -> Outcome:
        """End it because someone asked for it."""
        return self._finish(Outcome(End.CANCELED, retries=self.retries))

    def abort(self, error_code: ErrorCode, error_msg: str) -> Outcome:
        """End it because it cannot go on; the error names the doubts that came up on the way."""
        explained, doubts = self.doubts.explain(error_msg), self.doubts.sentences()
        return self._finish(Outcome(End.ABORTED, error_code, explained, self.retries, doubts))

    def _give_up(self, error_code: ErrorCode, error_msg: str) -> Outcome:
        """Abort the goal. One that had failed before, and was on its way back, ends with the first reason."""
        if self._stage is Stage.RETURN_TO_STAGING:
            failure = self._recovery.meanwhile(self._stage, error_msg)
            return self.abort(failure.error_code, str(failure))
        return self.abort(error_code, error_msg)

    def _finish(self, outcome: Outcome) -> Outcome:
        self._rest()
        if self.outcome is None:
            self.outcome = outcome
        return self.outcome

    # Commands to the robot.

    def pause(self) -> None:
        """The robot stands still, as time does; the next step goes on from there."""
        self._rest()

    def _rest(self) -> Velocity:
        if self._navigation is not None:
            self._navigation.interrupt()
        if self._pace is not None:
            self._pace.stop()
        if self._watch is not None:
            self._watch.rest()
        return STANDSTILL

    def _wait(self, stage: Stage, error_code: ErrorCode, reason: str, dt: float) -> Command | Outcome:
        """Stand still, and say why once it is worth a word; the sum of all waits has a limit, too."""
        if too_long := self._limits.wait(dt):
            lost = ErrorCode.BATTERY_LOST if error_code is ErrorCode.BATTERY_STALE else error_code
            return self._give_up(lost, f"{reason or stage.value}; {too_long}")
        waiting = self._command(self._rest())
        return replace(waiting, stage=stage, error_code=error_code, error_msg=reason) if reason else waiting

    def _command(self, velocity: Velocity, stage: Stage | None = None) -> Command:
        failure, poses = self._recovery.reason, self._plan.poses
        return Command(
            stage or self._stage,
            velocity,
            ErrorCode.NONE if failure is None else failure.error_code,
            "" if failure is None else str(failure),
            self.retries,
            poses.dock,
            poses.filtered_dock,
            poses.staging,
            note=poses.note,
        )
