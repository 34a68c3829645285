"""Docking servers that are not ours, with the protocols of nav2 (Jazzy) and the Create 3: `--offer nav2 create3`.

nav2: the dock's name decides. `home` and `other` succeed, `wobbly` after one retry, `slow` drives until it is canceled,
a number is the error code with which the goal is aborted, any other name is not in the database. A goal is accepted in
any case, unless the server is `--inactive`, and replaces a running one. To undock, the robot has to be on a dock: else
the goal is aborted without an error code. The server knows the dock's type if it has docked the robot, else the goal
has to say that it is of type `charger`.

Create 3: each goal to dock takes the next of `--outcomes`: `docked`, `missed` (ends, and is not docked), `gave-up`
(aborted), `slow` (drives until it is canceled). After the last one it docks. Docking a docked robot is rejected.
"""

import argparse
import contextlib
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any

import rclpy
from irobot_create_msgs.action import Dock, Undock
from nav2_msgs.action import DockRobot, UndockRobot
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future

PERIOD = 0.05
# Seconds of the longest goal, which is to be canceled.
SLOW = 120.0


class Server:
    """Action servers of one node, which cancel whatever they are asked to. All goals run in the thread that spins."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self._ticks: list[Future] = []
        node.create_timer(PERIOD, self._tick)

    def _tick(self) -> None:
        ticks, self._ticks = self._ticks, []
        for tick in ticks:
            tick.set_result(None)

    async def tick(self) -> None:
        """Wait a moment."""
        tick = Future()
        self._ticks.append(tick)
        await tick

    async def steps(self, seconds: float) -> AsyncIterator[None]:
        """Yield now and then until the time is over."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            yield
            await self.tick()

    def serve(
        self, kind: Any, name: str, execute: Callable[[Any], Coroutine[Any, Any, Any]], accept: Callable[[], bool]
    ) -> ActionServer:
        def decide(_: Any) -> GoalResponse:
            return GoalResponse.ACCEPT if accept() else GoalResponse.REJECT

        return ActionServer(
            self.node,
            kind,
            name,
            execute,
            goal_callback=decide,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            result_timeout=60,
        )


class Nav2(Server):
    """One robot and its docks."""

    def __init__(self, node: Node, *, active: bool, docked: bool, stage_time: float) -> None:
        super().__init__(node)
        self._docked = docked
        self._known_type = ""
        self._stage_time = stage_time
        self._newest: Any = None
        self._driving = False
        self.serve(DockRobot, "dock_robot", self.dock, lambda: active)
        self.serve(UndockRobot, "undock_robot", self.undock, lambda: active)

    @contextlib.asynccontextmanager
    async def _turn(self) -> AsyncIterator[None]:
        """Wait until no other goal drives the robot."""
        while self._driving:
            await self.tick()
        self._driving = True
        try:
            yield
        finally:
            self._driving = False

    async def dock(self, handle: Any) -> Any:
        self._newest = handle
        async with self._turn():
            result, feedback = DockRobot.Result(success=False), DockRobot.Feedback()
            await self._dock(handle, result, feedback)
            return result

    async def _dock(self, handle: Any, result: Any, feedback: Any) -> None:
        dock, kinds = handle.request.dock_id, DockRobot.Feedback
        if not handle.request.use_dock_id:
            dock = "home"
        code = int(dock) if dock.isdigit() else 0
        if not code and dock not in ("home", "other", "wobbly", "slow"):
            code = DockRobot.Result.DOCK_NOT_IN_DB
        if code in (DockRobot.Result.DOCK_NOT_IN_DB, DockRobot.Result.DOCK_NOT_VALID):
            result.error_code = code
            handle.abort()
            return
        approach = [(kinds.INITIAL_PERCEPTION, 0), (kinds.CONTROLLING, 0)]
        if dock == "wobbly":
            approach += [(stage, 1) for stage, _ in approach]
        for stage, retries in ((kinds.NAV_TO_STAGING_POSE, 0), *approach, (kinds.WAIT_FOR_CHARGE, approach[-1][1])):
            feedback.state, feedback.num_retries = stage, retries
            slow = dock == "slow" and stage == kinds.CONTROLLING
            if not await self._drive(handle, feedback, SLOW if slow else self._stage_time):
                return
        result.num_retries = feedback.num_retries
        if code:
            result.error_code, result.error_msg = code, f"failed with {code}"
            handle.abort()
            return
        self._docked, self._known_type = True, "charger"
        result.success = True
        handle.succeed()

    async def _drive(self, handle: Any, feedback: Any, seconds: float) -> bool:
        """Return whether it came to its end, neither canceled nor replaced by a newer goal."""
        async for _ in self.steps(seconds):
            handle.publish_feedback(feedback)
            if handle.is_cancel_requested:
                handle.canceled()
                return False
            if self._newest is not handle:
                handle.abort()
                return False
        return True

    async def undock(self, handle: Any) -> Any:
        async with self._turn():
            kind = handle.request.dock_type or self._known_type
            if kind != "charger":
                handle.abort()
                return UndockRobot.Result(success=False, error_code=UndockRobot.Result.DOCK_NOT_VALID)
            if not self._docked:
                handle.abort()  # nav2 does not set the result
                return UndockRobot.Result()
            async for _ in self.steps(self._stage_time):
                if handle.is_cancel_requested:
                    handle.canceled()
                    return UndockRobot.Result(success=False)
            self._docked, self._known_type = False, ""
            handle.succeed()
            return UndockRobot.Result(success=True)


def declare_docks(node: Node, docks: list[str]) -> None:
    """The parameters of nav2's database: what is not set has a type and no value."""
    node.declare_parameter("dock_database", Parameter.Type.STRING)
    node.declare_parameter("docks", docks or Parameter.Type.STRING_ARRAY)
    for dock in docks:
        node.declare_parameter(f"{dock}.type", "charger")
        node.declare_parameter(f"{dock}.frame", "map")
        node.declare_parameter(f"{dock}.pose", [1.0, 2.5, 0.5])
        node.declare_parameter(f"{dock}.id", Parameter.Type.STRING)


class Create3(Server):
    """One robot in front of its dock."""

    def __init__(self, node: Node, outcomes: list[str], *, stage_time: float, also: list[str]) -> None:
        super().__init__(node)
        self._outcomes = iter(outcomes)
        self._docked = False
        self._stage_time = stage_time
        for namespace in ("", *also):
            self.serve(Dock, f"{namespace}dock", self.dock, lambda: not self._docked)
        self.serve(Undock, "undock", self.undock, lambda: True)

    async def dock(self, handle: Any) -> Any:
        outcome = next(self._outcomes, "docked")
        for sees_dock in (False, True):
            async for _ in self.steps(SLOW if sees_dock and outcome == "slow" else self._stage_time):
                handle.publish_feedback(Dock.Feedback(sees_dock=sees_dock))
                if handle.is_cancel_requested:
                    handle.canceled()
                    return Dock.Result(is_docked=False)
        self._docked = outcome == "docked"
        if outcome == "gave-up":
            handle.abort()
        else:
            handle.succeed()
        return Dock.Result(is_docked=self._docked)

    async def undock(self, handle: Any) -> Any:
        async for _ in self.steps(self._stage_time):
            continue
        self._docked = False
        handle.succeed()
        return Undock.Result(is_docked=False)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--offer", nargs="+", choices=["nav2", "create3"], required=True)
    parser.add_argument("--robot", default="/")
    parser.add_argument("--inactive", action="store_true")
    parser.add_argument("--docked", action="store_true", help="nav2: the robot was docked before the server started")
    parser.add_argument("--docks", nargs="*", default=[], help="nav2: the docks in its parameters")
    parser.add_argument("--outcomes", nargs="*", default=[])
    parser.add_argument("--also", nargs="*", default=[], help="create3: prefixes of the same action by other names")
    parser.add_argument("--stage-time", type=float, default=0.3)
    arguments = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node("docking_server", namespace=arguments.robot)
    seconds = arguments.stage_time
    if "nav2" in arguments.offer:
        declare_docks(node, arguments.docks)
        Nav2(node, active=not arguments.inactive, docked=arguments.docked, stage_time=seconds)
    if "create3" in arguments.offer:
        Create3(node, arguments.outcomes, stage_time=seconds, also=arguments.also)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    print("serving", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
