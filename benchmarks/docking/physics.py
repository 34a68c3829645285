"""The robot and its dock in MuJoCo, a physics engine that others wrote: wheels roll and slip, contacts give way.

Camera, odometry, battery and delays are those of our simulator. What they measure is MuJoCo's: the camera sees the
marker from where the robot is in truth, and odometry counts what the wheels turn, whether they slip or not.
"""

import math
from collections.abc import Sequence
from functools import partial
from random import Random

import mujoco

from benchmarks.docking.cases import DOCK_POSE
from benchmarks.docking.comparison import LAWS, figures_of, with_laws
from benchmarks.docking.rows import Job, Table
from benchmarks.docking.trial import Trial, run_trial
from benchmarks.docking.worlds import WORLDS, Base
from docking.core.geometry import Pose, normalize_angle, quaternion_of
from docking.simulation.collisions import APART, Collisions, Touch
from docking.simulation.obstacle import Obstacle
from docking.simulation.robot import Robot, RobotSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

TICK = 0.002
"""Longest step of the engine, in s."""
WHEEL = 0.035
"""Radius of the wheels, in m."""
MODEL = """
<mujoco>
  <option timestep="{tick}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <default><geom friction="{friction} 0.005 0.0001"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="10 10 0.1"/>
    <geom name="wall" type="box" pos="0.21 0 0.25" size="0.05 3 0.25"/>
    <geom name="dock" type="box" pos="0.06 0 0.1" size="0.1 0.15 0.1"/>
    <body name="left pin" pos="-0.05 0.03 0.06">
      <joint type="slide" axis="1 0 0" stiffness="150" damping="5" range="0 0.02" limited="true"/>
      <geom name="left pin" type="box" size="0.01 0.0075 0.01" mass="0.01"/>
    </body>
    <body name="right pin" pos="-0.05 -0.03 0.06">
      <joint type="slide" axis="1 0 0" stiffness="150" damping="5" range="0 0.02" limited="true"/>
      <geom name="right pin" type="box" size="0.01 0.0075 0.01" mass="0.01"/>
    </body>
    <body name="robot">
      <freejoint/>
      <geom name="body" type="cylinder" pos="-0.02 0 0.04" size="0.13 0.03" mass="{mass}"/>
      <geom name="bumper" type="cylinder" pos="0 0 0.07" size="0.148 0.005" mass="0.01"/>
      <geom name="left pad" type="box" pos="0.14 0.03 0.025" size="0.01 0.0125 0.02" mass="0.01"/>
      <geom name="right pad" type="box" pos="0.14 -0.03 0.025" size="0.01 0.0125 0.02" mass="0.01"/>
      <geom name="caster" type="sphere" pos="-0.1 0 -0.015" size="0.02" mass="0.05" friction="0.02 0 0" priority="1"/>
      <body pos="0 {half} 0">
        <joint name="left" axis="0 1 0" damping="0.001" armature="0.001"/>
        <geom type="cylinder" size="{wheel} 0.01" euler="90 0 0" mass="0.1"/>
      </body>
      <body pos="0 -{half} 0">
        <joint name="right" axis="0 1 0" damping="0.001" armature="0.001"/>
        <geom type="cylinder" size="{wheel} 0.01" euler="90 0 0" mass="0.1"/>
      </body>
    </body>
    {other}
  </worldbody>
  <contact>
    <exclude body1="world" body2="left pin"/>
    <exclude body1="world" body2="right pin"/>
  </contact>
  <actuator>
    <velocity name="left" joint="left" kv="{gain}" forcerange="-{torque} {torque}"/>
    <velocity name="right" joint="right" kv="{gain}" forcerange="-{torque} {torque}"/>
  </actuator>
</mujoco>
"""
OTHER_ROBOT = """
    <body name="other" pos="-0.21 0 0.07">
      <joint type="slide" axis="1 0 0" damping="50"/>
      <joint type="slide" axis="0 1 0" damping="50"/>
      <geom name="other" type="cylinder" size="0.14 0.06" mass="5"/>
    </body>
"""
"""It can be pushed, but hardly; its wheels are blocked."""
PADS_AT_PINS = {frozenset({"left pad", "left pin"}), frozenset({"right pad", "right pin"})}
SOLID, ROLLING = {"dock", "wall", "left pin", "right pin", "other"}, {"", "caster", "floor"}
"""What the robot can run into, and what it does not run into things with."""


class RollingRobot(Robot):
    """A robot with two driven wheels and a caster; its driver ramps the speed of the wheels up and down."""

    def __init__(self, base: Base, settings: RobotSettings, pose: Pose, random: Random) -> None:
        """Set it down; see `Robot`."""
        text = MODEL.format(
            tick=TICK,
            wheel=WHEEL,
            half=0.5 * settings.wheel_separation,
            other=OTHER_ROBOT if base.other_robot else "",
            mass=base.mass,
            friction=base.friction,
            torque=base.torque,
            gain=base.gain,
        )
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)
        self._driver = settings
        self.base = base
        self.came_at = 0.0
        super().__init__(settings, pose, random)

    def place(self, pose: Pose) -> None:
        """Set it down standing still; see `Robot`."""
        super().place(pose)
        x, y, z, w = quaternion_of(pose.theta)
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[2:9] = (pose.x, pose.y, WHEEL, w, x, y, z)
        mujoco.mj_forward(self._model, self._data)
        self._set_linear = self._set_angular = 0.0

    def step(
        self, dt: float, *, halted: bool = False, stuck: bool = False, worn: float = 0.0, goes_on: bool = False
    ) -> None:
        """Drive on; see `Robot`. The faults of `stuck` and `worn` wheels are not for this one."""
        assert not stuck
        assert not worn
        driver, model, data = self._driver, self._model, self._data
        self._command_age += dt
        linear, angular = (0.0, 0.0) if halted or self._is_left_alone(goes_on) else self._target()
        self._set_linear = _ramp(self._set_linear, linear, driver.linear_acceleration * dt)
        self._set_angular = _ramp(self._set_angular, angular, driver.angular_acceleration * dt)
        half = 0.5 * driver.wheel_separation
        data.ctrl[:] = (
            (self._set_linear - half * self._set_angular) / WHEEL,
            (self._set_linear + half * self._set_angular) / WHEEL,
        )
        count = math.ceil(dt / TICK - 1e-9)
        model.opt.timestep = dt / count
        self.came_at = abs(self.linear)
        before = data.qpos[9:11].copy()
        mujoco.mj_step(model, data, count)
        self.left, self.right = (float(way) for way in WHEEL * (data.qpos[9:11] - before))
        left, right = (float(speed) for speed in WHEEL * data.qvel[8:10])
        self.linear, self.angular = 0.5 * (left + right), 0.5 * (right - left) / half
        self.x, self.y = float(data.qpos[2]), float(data.qpos[3])
        w, x, y, z = (float(part) for part in data.qpos[5:9])
        self.theta = normalize_angle(math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))

    @property
    def pressed(self) -> float:
        """How far both pins are pressed, in m."""
        return float(min(self._data.qpos[:2]))

    @property
    def touching(self) -> set[frozenset[str]]:
        """Pairs of names: what touches what."""
        pairs = self._data.contact.geom.tolist()
        return {frozenset(self._model.geom(geom).name for geom in pair) for pair in pairs}


class Plates(Collisions):
    """Tells from the engine's contacts whether current can flow: each of the robot's pads is at its pin of the dock."""

    def look(self, robot: Robot, obstacles: Sequence[Obstacle], now: float, *, driven: bool = True) -> None:
        """Take notice of the contacts; the engine itself keeps the robot out of the dock."""
        assert isinstance(robot, RollingRobot)
        touching = robot.touching
        self.contact = touching >= PADS_AT_PINS and robot.pressed >= robot.base.spring_travel
        if not self.contact:
            self._contact_since = None
        elif self._contact_since is None:
            self._contact_since = now
            self.presses += 1
        hits = [
            pair
            for pair in touching
            if pair & SOLID and not pair <= SOLID and not pair & ROLLING and pair not in PADS_AT_PINS
        ]
        blocked = bool(hits)
        if driven and blocked and not self._blocked and not self.contact:
            self.bumps += 1
        self._blocked = blocked
        touches = blocked or bool(touching & PADS_AT_PINS)
        if touches and not self._at_dock and driven:
            self.touches.append(Touch(now, robot.came_at, self.contact))
        clearance = self._dock.clearance(robot.x, robot.y) - robot.radius
        self._at_dock = touches or (self._at_dock and clearance < APART)


class PhysicsWorld(Simulation):
    """The simulation with another robot and another dock."""

    def __init__(self, base: Base, settings: Settings, seed: int) -> None:
        """Build it; see `Simulation`."""
        self._base = base
        super().__init__(settings, seed)

    def reset(self) -> None:
        """Begin again; see `Simulation`."""
        super().reset()
        settings = self.settings
        self.robot = RollingRobot(self._base, settings.robot, settings.start, self._random("robot"))
        self._collisions = Plates(self.dock, self._random("bounce"))


def _ramp(value: float, target: float, most: float) -> float:
    return value + min(most, max(-most, target - value))


def _run(job: Job) -> Trial:
    (name, law), seed = job
    base, case = WORLDS[name]
    return run_trial(DOCK_POSE, seed, case, LAWS[law], partial(PhysicsWorld, base))


PHYSICS = Table(
    "physics", ("case", "law"), with_laws({name: case for name, (_, case) in WORLDS.items()}), _run, figures_of
)
