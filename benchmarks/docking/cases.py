"""What real robots do to a docking goal: each case changes the simulation in one way."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from random import Random
from typing import Any

from docking.core.geometry import Pose, normalize_angle
from docking.parameters import ControllerName, DockDirection, DockSettings
from docking.parameters.limits import DriveModel
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DOCK_POSE, INFRARED = ControllerName.DOCK_POSE, ControllerName.INFRARED
BOTH = (DOCK_POSE, INFRARED)

Change = Callable[[Settings, Random], Settings]
Disturbance = Callable[[Simulation], None]
Makes = Callable[[Random], Disturbance]


def _leave_alone(_random: Random) -> Disturbance:
    return lambda simulation: None


@dataclass(frozen=True, slots=True)
class Region:
    """Where a robot may start.

    Attributes:
        nearest: From the marker, or the beacon, to base_link, in m.
        farthest: The same.
        off: How far off the dock's axis it may stand, both ways, in rad.
        least_off: How far off it stands at least, in rad.
        turned: How far off the direction to the dock it may look, both ways, in rad; None: as far as `off`.
    """

    nearest: float
    farthest: float
    off: float
    least_off: float = 0.0
    turned: float | None = None

    def draw(self, random: Random) -> Pose:
        """A start in world."""
        distance, aside = random.uniform(self.nearest, self.farthest), random.uniform(-self.off, self.off)
        while abs(aside) < self.least_off:
            aside = random.uniform(-self.off, self.off)
        x, y = -distance * math.cos(aside), distance * math.sin(aside)
        turned = self.off if self.turned is None else self.turned
        return Pose(x, y, normalize_angle(math.atan2(-y, -x) + random.uniform(-turned, turned)))


@dataclass(frozen=True)
class Case:
    """One row of the table.

    Attributes:
        name: As in the table.
        controllers: Which it is measured with.
        change: Makes the settings of one trial.
        disturb: Makes what happens before each control step of one trial.
        jitter: How much longer or shorter a control period is at most, as a fraction of it.
        region: Where the robot starts; None: in the usual region of the controller.
        known: Whether the database has the dock's pose, with an error of up to 10 cm each way and 5 degrees.
        search_radius: The parameter, in m.
        recovers: Whether the robot presses again without a charge, and goes back to its staging pose in the end.
        parameters: Changes the parameters of the docking server.
        why: Sentences for docs/docking-results.md: why less than 95 % of its goals dock. Empty for the other rows.
        final_push: The parameter, in m.
        located: Whether the dock is not detected, but known by the database and the localization alone. The robot feels
            for the contacts then, so that slow touches beside them are no failure.
    """

    name: str
    controllers: tuple[ControllerName, ...]
    change: Change = lambda settings, random: settings
    disturb: Callable[[Random], Disturbance] = _leave_alone
    jitter: float = 0.0
    region: Region | None = None
    known: bool = False
    search_radius: float = 0.0
    recovers: bool = False
    parameters: Callable[[DockSettings], DockSettings] = lambda settings: settings
    why: str = ""
    final_push: float = 0.0
    located: bool = False


def _set(part: str, **values: Any) -> Change:
    """Change some fields of one part of the settings, or of the settings themselves if `part` is empty."""

    def change(settings: Settings, _random: Random) -> Settings:
        return replace(settings, **({part: replace(getattr(settings, part), **values)} if part else values))

    return change


def _all(*changes: Change) -> Change:
    def change(settings: Settings, random: Random) -> Settings:
        for one in changes:
            settings = one(settings, random)
        return settings

    return change


def _slowest(speed: float) -> Callable[[DockSettings], DockSettings]:
    """v_linear_min, in m/s."""
    return lambda settings: replace(settings, motion=replace(settings.motion, v_linear_min=speed))


def _flickering(battery_rate: float) -> Change:
    return _all(_set("dock", flickers=True), _set("battery", battery_rate=battery_rate))


def _omni(settings: DockSettings) -> DockSettings:
    """The base drives sideways, too."""
    return replace(settings, motion=replace(settings.motion, motion_model=DriveModel.OMNI))


def _one_wheel(error: float) -> Change:
    """One of the wheels, the left or the right one, is larger or smaller."""

    def change(settings: Settings, random: Random) -> Settings:
        wheel = random.choice(("left_wheel_error", "right_wheel_error"))
        return _set("robot", **{wheel: random.choice((error, -error))})(settings, random)

    return change


def _mounted(distance: float, angle: float) -> Change:
    """The camera is turned, and to the left or to the right of where it is taken to be."""

    def change(settings: Settings, random: Random) -> Settings:
        error = Pose(0.0, random.choice((distance, -distance)), random.choice((angle, -angle)))
        return _set("marker", mount_error=error)(settings, random)

    return change


def _aside(distance: float) -> Change:
    """The camera is mounted to the left or to the right of where it is taken to be."""

    def change(settings: Settings, random: Random) -> Settings:
        return _set("marker", camera_error_y=random.choice((distance, -distance)))(settings, random)

    return change


def _rotates(settings: DockSettings) -> DockSettings:
    """With rotate_to_dock."""
    return replace(settings, dock=replace(settings.dock, dock_direction=DockDirection.BACKWARD, rotate_to_dock=True))


def _turned(angle: float) -> Change:
    """The marker is turned on its dock, to the left or to the right."""

    def change(settings: Settings, random: Random) -> Settings:
        return _set("marker", angle_bias=random.choice((angle, -angle)))(settings, random)

    return change


def _two_tags(settings: Settings, random: Random) -> Settings:
    """A second tag is 0.5 to 1.5 m to the left or to the right of the dock's."""
    return _set("marker", second_y=random.choice((1.0, -1.0)) * random.uniform(0.5, 1.5))(settings, random)


def _sprung(settings: Settings, random: Random) -> Settings:
    """The contacts need 2 to 5 cm more push."""
    return _set("dock", travel=random.uniform(0.02, 0.05))(settings, random)


def _off(distance: float, angle: float = math.radians(4.0), jump: float = 0.0) -> Change:
    """By the localization the dock is somewhere at a distance from where it is, and turned by up to an angle."""

    def change(settings: Settings, random: Random) -> Settings:
        way, yaw = random.uniform(-math.pi, math.pi), random.uniform(-angle, angle)
        x, y = distance * math.cos(way), distance * math.sin(way)
        return _set("localization", error_x=x, error_y=y, error_yaw=yaw, noise=0.005, jump=jump)(settings, random)

    return change


def _push_often(random: Random) -> Disturbance:
    """About once in four seconds, someone pushes the robot."""

    def push(simulation: Simulation) -> None:
        if random.random() < 0.0125:
            simulation.push(Pose(random.uniform(-0.04, 0.04), random.uniform(-0.04, 0.04), random.uniform(-0.1, 0.1)))

    return push


def _dirty(_random: Random) -> Disturbance:
    """No current flows at the first contact."""
    return lambda simulation: simulation.set_fault(Fault.DIRTY_CONTACTS, True)


def _occupied(_random: Random) -> Disturbance:
    """Another robot stands on the dock."""
    return lambda simulation: simulation.set_fault(Fault.OCCUPIED_DOCK, True)


def _push_once(random: Random) -> Disturbance:
    """Someone pushes the robot 10 cm to one side when it is less than 20 cm from its dock, but not yet there."""
    distance, way, pushed = random.uniform(0.03, 0.2), random.choice((0.1, -0.1)), False

    def push(simulation: Simulation) -> None:
        nonlocal pushed
        if not pushed and simulation.robot.pose.distance_to(DOCKED) < distance:
            pushed = True
            simulation.push(Pose(0.0, way))

    return push


def _from_a_moment(*faults: Fault, first: float = 0.0, last: float = 0.0, lasts: float = math.inf) -> Makes:
    """Faults that begin at a random moment, and last for up to some time.

    Args:
        faults: What is broken from then on.
        first: The earliest moment, in s.
        last: The latest one.
        lasts: How long it lasts at most, in s.
    """

    def make(random: Random) -> Disturbance:
        begins = random.uniform(first, last)
        ends = begins + random.uniform(1.0, max(1.0, lasts)) if lasts < math.inf else math.inf

        def switch(simulation: Simulation) -> None:
            for fault in faults:
                simulation.set_fault(fault, begins <= simulation.time < ends)

        return switch

    return make


def _held(random: Random) -> Disturbance:
    """From a random moment on something holds the robot, and odometry goes on to report the commands."""
    begins = random.uniform(1.0, 20.0)

    def hold(simulation: Simulation) -> None:
        simulation.set_fault(Fault.OPEN_LOOP_ODOMETRY, True)
        simulation.halted = simulation.time >= begins

    return hold


BEHIND = Region(0.6, 2.5, math.radians(180.0), math.radians(110.0))
FAR = Region(4.3, 6.0, math.radians(60.0), turned=math.radians(180.0))
OFF_AXIS = Region(0.6, 2.5, math.radians(105.0), math.radians(77.0), math.radians(180.0))
NARROW = _set("marker", field_of_view=math.radians(50.0), range=1.2)

OMNI = _set("robot", omnidirectional=True)
DEAD_ZONE = _set("robot", linear_dead_zone=0.13)
NOT_SO_SLOWLY = (
    "The base does not move slowly enough to touch a dock. The error says so, and to set v_linear_min: it touches its"
    " dock faster only where that was chosen."
)
FUTURE = "Detections that are stamped more than 0.25 s ahead are not believed, and the error says so."
TURNED = (
    "A marker that is turned on its dock cannot be detected before contact: the robot touches beside the contacts, at"
    " v_linear_min. The next goal begins with the turn at which it charged; these goals are the first ones."
)
WHEEL = "The axis of the dock is not known well enough, and the robot touches the dock next to its contacts."
WEAK = (
    "`infrared` looks for the edge of the light on short ways to and fro, which such a base drives slowly: the time is"
    " over (staging_timeout)."
)
PUSHED = "A robot that is pushed within the last 3 cm misses the contacts: no controller sees that in time."
FLICKERS = "A charge that comes and goes forever is no charge, and the error says so."
CAMERA = "The dock seems to turn as the robot comes near: it gives up before contact."
TWO_TAGS = "Without the dock's pose, nothing decides which of the two tags is the dock's."
UNSEEN = "The dock cannot be seen from there, and nothing says where it is: give its pose, or set search_radius."
SEARCHES = "Driving around to look for the dock does not always come to where it can be seen: give its pose."
ASIDE = (
    "A camera that is not where tf has it looks the same as a dock that is not, until the first contact: beside the"
    " contacts, at v_linear_min."
)
OCCUPIED = (
    "No robot docks there: without a scan the robot runs into the other one, at the speed of the way. It comes back to"
    " that place at v_linear_min, and the error says where it was blocked, and how often."
)
FROZEN = (
    "What does not move as the robot drives is not believed: the robot stands still, and the error says so. It docks"
    " where the fault began after it was on the contacts, or where it ended in time."
)
TWO_FOLD = (
    "Each detection is one of two poses, at random. Near the dock the two are so alike that the wrong one passes as"
    " noise: the robot gives up before contact, with the reason."
)
BLINDLY = "The robot backs onto the dock without seeing it; what odometry misjudges shows only at the contact."
"""Why less than 95 % of the goals of a row dock."""

CASES = (
    Case("none", BOTH),
    Case("marker noise 2 cm, 3°", (DOCK_POSE,), _set("marker", noise=0.02, angle_noise=0.052)),
    Case("marker noise 5 cm, 8°", (DOCK_POSE,), _set("marker", noise=0.05, angle_noise=0.14)),
    Case(
        "marker noise +2 cm per m, +6° per rad off the axis",
        (DOCK_POSE,),
        _set("marker", noise_per_metre=0.02, noise_per_radian=0.1),
    ),
    Case("marker at 5 Hz", (DOCK_POSE,), _set("marker", rate=5.0)),
    Case("marker at 2 Hz", (DOCK_POSE,), _set("marker", rate=2.0)),
    Case("marker at 1 Hz", (DOCK_POSE,), _set("marker", rate=1.0)),
    Case("30 % of the detections wrong", (DOCK_POSE,), _set("marker", outliers=0.3)),
    Case("15 % of the detections of a reflection", (DOCK_POSE,), _set("marker", ghosts=0.15)),
    Case("marker hidden 2 s every 8 s", (DOCK_POSE,), _set("marker", hidden_every=8.0, hidden_for=2.0)),
    Case("camera off by 5 mm, 1.5°", (DOCK_POSE,), _mounted(0.005, 0.026)),
    Case("detections 0.3 s late", (DOCK_POSE,), _set("marker", delay=0.3)),
    Case("detections 0.15 s late, wrong stamps", (DOCK_POSE,), _set("marker", delay=0.15, honest_stamps=False)),
    Case("detections stamped 0.2 s ahead", (DOCK_POSE,), _set("marker", stamp_offset=0.2)),
    Case("detections stamped 0.3 s ahead", (DOCK_POSE,), _set("marker", stamp_offset=0.3), why=FUTURE),
    Case("marker turned by 4°", (DOCK_POSE,), _turned(math.radians(4.0)), why=TURNED),
    Case("marker turned by 6°", (DOCK_POSE,), _turned(math.radians(6.0)), why=TURNED),
    Case("commands 0.15 s late", BOTH, _set("", command_delay=0.15)),
    Case("commands 0.2 s late", (INFRARED,), _set("", command_delay=0.2)),
    Case("commands 0.3 s late", BOTH, _set("", command_delay=0.3)),
    Case("odometry 0.2 s late", BOTH, _set("odometry", delay=0.2)),
    Case("odometry 0.2 s late, wrong stamps", (DOCK_POSE,), _set("odometry", delay=0.2, honest_stamps=False)),
    Case("commands and odometry 0.2 s late each", BOTH, _all(_set("", command_delay=0.2), _set("odometry", delay=0.2))),
    Case("base accelerates at 0.2 m/s²", BOTH, _set("robot", linear_acceleration=0.2)),
    Case(
        "base accelerates at 0.2 m/s² and 1 rad/s²",
        BOTH,
        _set("robot", linear_acceleration=0.2, angular_acceleration=1.0),
    ),
    Case("base brakes at 0.1 m/s²", BOTH, _set("robot", linear_braking=0.1)),
    Case("base accelerates and brakes at 0.1 m/s²", BOTH, _set("robot", linear_acceleration=0.1), why=WEAK),
    Case("base clamps at 0.15 m/s, 0.5 rad/s", BOTH, _set("robot", linear_max=0.15, angular_max=0.5)),
    Case("dead zone 0.05 m/s, 0.1 rad/s", BOTH, _set("robot", linear_dead_zone=0.05, angular_dead_zone=0.1)),
    Case("omnidirectional base", (DOCK_POSE,), OMNI, parameters=_omni),
    Case(
        "omnidirectional base, pushed 10 cm sideways in the last 20 cm",
        (DOCK_POSE,),
        OMNI,
        disturb=_push_once,
        parameters=_omni,
    ),
    Case("dead zone 0.13 m/s", BOTH, DEAD_ZONE, why=NOT_SO_SLOWLY),
    Case("dead zone 0.13 m/s, v_linear_min 0.15 m/s", BOTH, DEAD_ZONE, parameters=_slowest(0.15)),
    Case("dead zone 0.15 rad/s", BOTH, _set("robot", angular_dead_zone=0.15)),
    Case("one wheel 5 % off", BOTH, _one_wheel(0.05)),
    Case("one wheel 10 % off", BOTH, _one_wheel(0.1), why=WHEEL),
    Case("both wheels 8 % larger", BOTH, _set("robot", left_wheel_error=0.08, right_wheel_error=0.08)),
    Case("both wheels 8 % smaller", BOTH, _set("robot", left_wheel_error=-0.08, right_wheel_error=-0.08)),
    Case("slip 10 %", BOTH, _set("robot", slip=0.1)),
    Case("beacon hidden 0.5 s every 10 s", (INFRARED,), _set("infrared", hidden_every=10.0, hidden_for=0.5)),
    Case("ghost readings 2 %", (INFRARED,), _set("infrared", ghosts=0.02)),
    Case("ghost readings 10 %", (INFRARED,), _set("infrared", ghosts=0.1)),
    Case("odometry without velocity", BOTH, _set("odometry", twist=False)),
    Case("odometry repeats itself 0.5 s every 3 s", BOTH, _set("odometry", repeat_every=3.0, repeat_for=0.5)),
    Case(
        "odometry repeats itself 0.5 s every 3 s, old stamps",
        BOTH,
        _set("odometry", repeat_every=3.0, repeat_for=0.5, repeat_stamps=True),
    ),
    Case(
        "odometry repeats itself 0.5 s every 3 s, no velocity",
        BOTH,
        _set("odometry", repeat_every=3.0, repeat_for=0.5, twist=False),
    ),
    Case("control period jitters by 80 %", BOTH, jitter=0.8),
    Case("pushed 4 cm, 6° every 4 s", (DOCK_POSE,), disturb=_push_often, why=PUSHED),
    Case("contacts bounce for 1 s", BOTH, _set("dock", bounce=1.0)),
    Case("charge flickers", BOTH, _set("dock", flickers=True), why=FLICKERS),
    Case("charge flickers, battery at 2 Hz", BOTH, _flickering(2.0), why=FLICKERS),
    Case("charge flickers, battery at 1 Hz", BOTH, _flickering(1.0), why=FLICKERS),
    Case("charge flickers, battery at 0.2 Hz", BOTH, _flickering(0.2), why=FLICKERS),
    Case("battery at 1 Hz", BOTH, _set("battery", battery_rate=1.0)),
    Case("battery at 0.2 Hz", BOTH, _set("battery", battery_rate=0.2)),
    Case("another robot stands on the dock", BOTH, disturb=_occupied, why=OCCUPIED),
    Case("dirty contacts", BOTH, disturb=_dirty),
    Case("dirty contacts, pressed again", BOTH, disturb=_dirty, recovers=True),
    Case("contacts on springs, 2 to 5 cm more push", BOTH, _sprung, final_push=0.06),
    Case("no marker, pose off by 1 cm, up to 4°", (DOCK_POSE,), _off(0.01), located=True),
    Case("no marker, pose off by 4 cm, up to 4°", (DOCK_POSE,), _off(0.04), located=True),
    Case("no marker, pose off by 8 cm, up to 4°", (DOCK_POSE,), _off(0.08), located=True),
    Case("no marker, localization jumps 5 to 20 cm", (DOCK_POSE,), _off(0.01, 0.02, jump=0.2), located=True),
    Case("a lip that takes 1.5 s of pushing", BOTH, _set("dock", lip=1.5), final_push=0.06),
    Case("camera 5 cm farther back than said", (DOCK_POSE,), _set("marker", camera_error_x=-0.05)),
    Case("camera 5 cm farther ahead than said", (DOCK_POSE,), _set("marker", camera_error_x=0.05)),
    Case("bumper 8 cm longer than said", (DOCK_POSE,), _set("robot", bumper=0.08)),
    Case("camera turned by 4°", (DOCK_POSE,), _mounted(0.0, math.radians(4.0)), why=CAMERA),
    Case("camera turned by 6°", (DOCK_POSE,), _mounted(0.0, math.radians(6.0)), why=CAMERA),
    Case("camera 3 cm aside", (DOCK_POSE,), _aside(0.03), why=ASIDE),
    Case("two-fold ambiguity of a flat marker", (DOCK_POSE,), _set("marker", mirrored=0.5), why=TWO_FOLD),
    Case(
        "rotate_to_dock with 5 % slip in turns",
        (DOCK_POSE,),
        _all(_set("robot", turn_slip=0.05), _set("dock", at_back=True)),
        parameters=_rotates,
        why=BLINDLY,
    ),
    Case("marker not seen below 0.30 m", (DOCK_POSE,), _set("marker", range_min=0.3)),
    Case(
        "half-visible marker, biased", (DOCK_POSE,), _set("marker", cut_off_bias=1.0, field_of_view=math.radians(40.0))
    ),
    Case("noise grows with the square of the distance", (DOCK_POSE,), _set("marker", noise_per_square_metre=0.02)),
    Case("pushed 10 cm sideways in the last 20 cm", BOTH, disturb=_push_once),
    Case("two tags on one topic", (DOCK_POSE,), _two_tags, why=TWO_TAGS),
    Case("two tags on one topic, pose known", (DOCK_POSE,), _two_tags, known=True),
    Case("starts behind the dock", BOTH, region=BEHIND, why=UNSEEN),
    Case("starts behind the dock, pose known", BOTH, region=BEHIND, known=True),
    Case("starts behind the dock, search_radius 4 m", (DOCK_POSE,), region=BEHIND, search_radius=4.0, why=SEARCHES),
    Case("starts 4.3 to 6 m away", BOTH, region=FAR, why=UNSEEN),
    Case("starts 4.3 to 6 m away, pose known", BOTH, region=FAR, known=True),
    Case("starts 4.3 to 6 m away, search_radius 4 m", (DOCK_POSE,), region=FAR, search_radius=4.0, why=SEARCHES),
    Case("starts 77° to 105° off the axis", BOTH, region=OFF_AXIS, why=UNSEEN),
    Case("starts 77° to 105° off the axis, pose known", BOTH, region=OFF_AXIS, known=True),
    Case("starts 77° to 105° off the axis, search_radius 4 m", (DOCK_POSE,), region=OFF_AXIS, search_radius=4.0),
    Case("camera sees 50° and 1.2 m", (DOCK_POSE,), NARROW, why=UNSEEN),
    Case("camera sees 50° and 1.2 m, pose known", (DOCK_POSE,), NARROW, known=True),
    Case("camera sees 50° and 1.2 m, search_radius 4 m", (DOCK_POSE,), NARROW, search_radius=4.0, why=SEARCHES),
    Case("camera frozen from the start", (DOCK_POSE,), disturb=_from_a_moment(Fault.FROZEN_CAMERA), why=FROZEN),
    Case("camera freezes", (DOCK_POSE,), disturb=_from_a_moment(Fault.FROZEN_CAMERA, first=1.0, last=20.0), why=FROZEN),
    Case(
        "camera freezes for 1 to 5 s",
        (DOCK_POSE,),
        disturb=_from_a_moment(Fault.FROZEN_CAMERA, first=1.0, last=15.0, lasts=5.0),
        why=FROZEN,
    ),
    Case(
        "detector extrapolates for 1 to 5 s",
        (DOCK_POSE,),
        disturb=_from_a_moment(Fault.EXTRAPOLATING_CAMERA, first=1.0, last=15.0, lasts=5.0),
        why=FROZEN,
    ),
    Case("detections 0.3 s late, wrong stamps", (DOCK_POSE,), _set("marker", delay=0.3, honest_stamps=False)),
    Case("detections 0.5 s late, wrong stamps", (DOCK_POSE,), disturb=_from_a_moment(Fault.LAGGING_DETECTIONS)),
    Case("detections 0.8 s late, wrong stamps", (DOCK_POSE,), _set("marker", delay=0.8, honest_stamps=False)),
    Case("odometry freezes", BOTH, disturb=_from_a_moment(Fault.FROZEN_ODOMETRY, first=1.0, last=20.0), why=FROZEN),
    Case(
        "odometry freezes, no velocity",
        BOTH,
        _set("odometry", twist=False),
        disturb=_from_a_moment(Fault.FROZEN_ODOMETRY, first=1.0, last=20.0),
        why=FROZEN,
    ),
    Case("odometry reports commands, robot held", (DOCK_POSE,), disturb=_held, why=FROZEN),
    Case("beacon frozen from the start", (INFRARED,), disturb=_from_a_moment(Fault.FROZEN_BEACON), why=FROZEN),
    Case("beacon freezes", (INFRARED,), disturb=_from_a_moment(Fault.FROZEN_BEACON, first=1.0, last=40.0), why=FROZEN),
    Case(
        "scan frozen, something in the way",
        (DOCK_POSE,),
        disturb=_from_a_moment(Fault.FROZEN_SCAN, Fault.OBSTACLE, first=0.5, last=0.5),
        search_radius=4.0,
        why=FROZEN,
    ),
    Case(
        "all at once, milder",
        (DOCK_POSE,),
        _all(
            _set("", command_delay=0.1),
            _set("odometry", delay=0.1, twist=False),
            _set("marker", rate=5.0, noise=0.02, angle_noise=0.052, delay=0.1, outliers=0.05),
            _set("robot", linear_acceleration=0.3, linear_dead_zone=0.03, angular_dead_zone=0.05, linear_max=0.2),
            _one_wheel(0.03),
        ),
    ),
)
"""In the order of the table."""
CASES_BY_NAME = {case.name: case for case in CASES}
