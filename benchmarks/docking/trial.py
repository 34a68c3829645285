"""One docking goal from one random start, and what became of it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from random import Random

from benchmarks.docking.cases import CASES, Case, Region
from benchmarks.docking.graceful import FREQUENCY, GracefulGoal, GracefulLaw
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import watch_obstacles
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import ControllerName, DockDatabase, DockEntry, DockSettings, MotionLimits
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from docking.simulation.localization import RATE
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

LONGEST = 1200.0
"""Simulated seconds after which a trial is given up."""
TRAIL_PERIOD = 0.2
"""Simulated seconds between two points of a trail."""
SETTLING = 1.0
"""Simulated seconds for which the robot stands before it is measured where."""
ROUNDING = 1e-9

World = Callable[[Settings, int], Simulation]

REGIONS = {
    ControllerName.DOCK_POSE: Region(0.45, 2.5, math.radians(60.0)),
    ControllerName.INFRARED: Region(0.45, 1.0, math.radians(30.0)),
}
DROP_OUTS = 0.2
"""The part of the camera's pictures in which the marker is not found."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What became of one start.

    Attributes:
        seed: Which start.
        docked: Whether the goal succeeded, with the robot in the contact zone also a second later, and without having
            run into the dock outside of it.
        error_code: How the goal ended, NONE where it succeeded.
        error_msg: Why it failed; empty where it succeeded.
        seconds: Simulated, from the goal's acceptance to its end.
        retries: How often the robot backed off and tried again.
        bumps: How often it ran into the dock outside the contact zone.
        contacts: The speeds of the wheels when the robot came onto the dock's contacts or ran into the dock, in m/s.
        hits: The speeds of the wheels just before it drove into something that is not the dock, in m/s.
        aside: How far the robot stands to the left or right of the docked pose in the end, in m.
        askew: How far it is turned against the docked pose, in rad.
        v_linear: The highest that was told or driven, in m/s.
        v_angular: The highest that was told or driven, in rad/s.
        a_linear: The highest change of what was told, but for stops, in m/s².
        a_angular: The same in rad/s².
        trail: Where base_link was, in world.
    """

    seed: int
    docked: bool
    error_code: str
    error_msg: str
    seconds: float
    retries: int
    bumps: int
    contacts: tuple[float, ...]
    hits: tuple[float, ...]
    aside: float
    askew: float
    v_linear: float
    v_angular: float
    a_linear: float
    a_angular: float
    trail: tuple[tuple[float, float], ...]


def settings_of(controller: ControllerName, case: Case = CASES[0]) -> DockSettings:
    """The defaults, with a controller; a robot that searches by driving watches its way."""
    settings, searches = DockSettings(controller=controller), case.search_radius > 0.0
    if case.located:
        home = {"home": DockEntry(pose=(DOCKED.x, DOCKED.y, DOCKED.theta))}
        settings = replace(
            settings,
            dock=replace(settings.dock, use_external_detection_pose=False),
            database=DockDatabase(docks=("home",), entries=home),
        ).at_dock("home")
    return case.parameters(
        replace(
            settings,
            search=replace(settings.search, search_radius=case.search_radius),
            approach=replace(settings.approach, final_push=case.final_push),
            collision=replace(settings.collision, use_collision_detection=searches),
        )
    )


def simulation_of(
    controller: ControllerName, seed: int, case: Case = CASES[0], world: World = Simulation
) -> Simulation:
    """A simulated robot at the start of a seed."""
    start = (case.region or REGIONS[controller]).draw(Random(f"{seed} start"))
    settings = Settings(start=start, marker=replace(MarkerSettings(), drop_outs=DROP_OUTS))
    return world(case.change(settings, Random(f"{seed} case")), seed)


def _database_error(random: Random) -> Pose:
    """How far off the docked pose is by the database and a localization: up to 10 cm each way and 5 degrees."""
    return Pose(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.09, 0.09))


def _observe(simulation: Simulation, database_error: Pose | None, *, located: bool = False) -> Observation:
    """What is known now; also where the database has the dock, if its error is given, or the localization."""
    if located:
        heard_at = math.floor(RATE * simulation.time) / RATE
        return replace(simulation.observe(), expected_dock=simulation.located_docked, localized_at=heard_at)
    if database_error is None:
        return simulation.observe()
    odom = simulation.odometry.pose.compose(simulation.robot.pose.inverse())
    return replace(simulation.observe(), expected_dock=odom.compose(DOCKED.compose(database_error)))


def run_trial(
    controller: ControllerName,
    seed: int,
    case: Case = CASES[0],
    law: GracefulLaw | None = None,
    world: World = Simulation,
) -> Trial:
    """Dock once.

    Args:
        controller: Ours.
        seed: Which start.
        case: What is wrong with the robot.
        law: What drives from the staging pose on; None is the controller.
        world: Makes the simulation.
    """
    simulation, settings = simulation_of(controller, seed, case, world), settings_of(controller, case)
    if law is not None:
        settings = replace(settings, controller_frequency=FREQUENCY)
    simulation.scanning = settings.collision.use_collision_detection
    off = _database_error(Random(f"{seed} database")) if case.known else None
    random = Random(f"{seed} disturbances")
    disturb = case.disturb(random)
    objective = Docking(settings.timeouts, recovery=settings.recovery if case.recovers or case.located else None)
    own = Goal(make_plan(settings), objective, simulation.time, watch_obstacles(settings))
    goal = own if law is None else GracefulGoal(own, law, settings)
    speeds, period, hits = _Speeds(), settings.control_period, list[float]()
    trail = [(simulation.robot.x, simulation.robot.y)]
    step: Command | Outcome = goal.step(_observe(simulation, off, located=case.located))
    while isinstance(step, Command) and simulation.time < LONGEST:
        speeds.told(step.velocity, period)
        disturb(simulation)
        period = settings.control_period * (1.0 + random.uniform(-case.jitter, case.jitter))
        bumps, touches, speed = simulation.bumps, len(simulation.touches), abs(simulation.robot.velocity.linear_x)
        simulation.run(period, step.velocity)
        if simulation.bumps > bumps and len(simulation.touches) == touches and speed > 0.0:
            hits.append(speed)
        speeds.driven(simulation.robot.velocity)
        if simulation.time >= TRAIL_PERIOD * len(trail):
            trail.append((simulation.robot.x, simulation.robot.y))
        step = goal.step(_observe(simulation, off, located=case.located))
    seconds = simulation.time
    simulation.run(SETTLING, STANDSTILL)
    robot = simulation.robot.pose
    succeeded = isinstance(step, Outcome) and step.end is End.SUCCEEDED
    return Trial(
        seed=seed,
        docked=succeeded and simulation.contact and (simulation.bumps == 0 or case.located),
        error_code=step.error_code.value if isinstance(step, Outcome) else "NO_END",
        error_msg=step.error_msg,
        seconds=seconds,
        retries=step.retries,
        bumps=simulation.bumps,
        contacts=tuple(touch.speed for touch in simulation.touches),
        hits=tuple(hits),
        aside=abs(robot.y - DOCKED.y),
        askew=abs(normalize_angle(robot.theta - DOCKED.theta)),
        v_linear=speeds.v_linear,
        v_angular=speeds.v_angular,
        a_linear=speeds.a_linear,
        a_angular=speeds.a_angular,
        trail=(*trail, (robot.x, robot.y)),
    )


def keeps_limits(trial: Trial, limits: MotionLimits) -> bool:
    """Whether nothing was too fast."""
    return (
        trial.v_linear <= limits.v_linear_max + ROUNDING
        and trial.v_angular <= limits.v_angular_max + ROUNDING
        and trial.a_linear <= limits.a_linear_max + ROUNDING
        and trial.a_angular <= limits.a_angular_max + ROUNDING
    )


class _Speeds:
    """The highest there were."""

    def __init__(self) -> None:
        self.v_linear = self.v_angular = self.a_linear = self.a_angular = 0.0
        self._last = STANDSTILL

    def told(self, velocity: Velocity, period: float) -> None:
        self.driven(velocity)
        if velocity != STANDSTILL:
            self.a_linear = max(self.a_linear, abs(velocity.linear_x - self._last.linear_x) / period)
            self.a_angular = max(self.a_angular, abs(velocity.angular_z - self._last.angular_z) / period)
        self._last = velocity

    def driven(self, velocity: Velocity) -> None:
        self.v_linear = max(self.v_linear, abs(velocity.linear_x))
        self.v_angular = max(self.v_angular, abs(velocity.angular_z))
