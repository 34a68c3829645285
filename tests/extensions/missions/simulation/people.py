"""What people do in a run: they queue missions, pause, continue, skip and cancel them, stop robots, and send goals."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.extensions.missions.mission import MissionEntry, MissionStatus
from dock_gateway.extensions.missions.schedules.schedule import ScheduleBody
from dock_gateway.extensions.missions.schedules.schedules import Schedules
from dock_gateway.extensions.missions.schema import MissionBody
from dock_gateway.extensions.missions.templates.template import TemplateBody
from dock_gateway.extensions.missions.templates.templates import Templates
from tests.extensions.missions.simulation.random_missions import TEMPLATE, TEMPLATE_ID, Made, RandomMissions
from tests.extensions.missions.simulation.stored import repair_docks, robot_of

if TYPE_CHECKING:
    from tests.extensions.missions.simulation.gateway import Gateway
    from tests.extensions.missions.simulation.world import World

Ask = Callable[["Gateway"], Awaitable[Any]]
Way = Callable[[str, MissionEntry], Awaitable[None]]


class People:
    """People, who ask whichever gateway runs.

    Args:
        world: The run.
    """

    def __init__(self, world: "World") -> None:
        self._world = world
        self._random = world.chance.random
        self._say = world.chance.say
        self._checks = world.checks
        self._missions = RandomMissions(self._random, world.docks.names)

    async def _ask(self, what: str, ask: Ask) -> bool:
        """Ask a gateway for something; return whether it has been done."""
        able = [gateway for gateway in self._world.gateways if gateway.ready and not gateway.dead]
        if not able:
            return False
        gateway = self._random.choice(able)
        self._say("people", f"{what} at {gateway.name}")
        work: Any = ask(gateway)
        task = gateway.spawn(work)
        await asyncio.wait({task})
        if task.cancelled():
            return False
        error = task.exception()
        if error is not None and not isinstance(error, GatewayError | OSError):
            raise error
        self._say("people", f"{what}: {'done' if error is None else error}")
        return error is None

    async def _insist(self, what: str, ask: Ask) -> None:
        """Ask until it has been done."""
        while True:
            if await self._ask(what, ask):
                return
            await asyncio.sleep(self._random.uniform(1, 10))

    async def queue(self, robot: str) -> None:
        """Queue a mission for a robot."""
        await self._queue(self._missions.make(robot), robot)

    async def queue_for_group(self) -> None:
        """Queue a mission for whichever robot of a group takes it."""
        group = self._random.choice(sorted(self._world.groups))
        await self._queue(self._missions.make_for_group(group), None)
        self._checks.counts["for groups"] += 1

    async def _queue(self, made: Made, robot: str | None) -> None:
        mission_id, body = made.mission_id, MissionBody.model_validate_json(json.dumps(made.request))
        steps = MissionBody.model_validate_json(json.dumps({"steps": made.steps}))
        self._checks.queued(mission_id, steps.entry(robot), body.group)
        self._say("people", f"{mission_id} {robot} {made.request}")
        await self._insist(
            f"queue {mission_id}", lambda gateway: gateway.missions.add(mission_id, body, robot, UNLIMITED)
        )
        self._checks.counts["missions"] += 1

    async def store_template(self) -> None:
        """Store the template that some missions are made of."""
        template = TemplateBody.model_validate_json(json.dumps(TEMPLATE)).entry()
        await self._insist(
            "store the template", lambda gateway: gateway.parts[Templates].replace(TEMPLATE_ID, template)
        )

    async def store_schedule(self, robot: str) -> None:
        """Let a schedule queue missions for a robot."""
        body = ScheduleBody.model_validate_json(
            json.dumps(self._missions.schedule(robot, self._world.troubles.schedule_minutes))
        )
        await self._insist(
            f"store the schedule {robot[1:]}",
            lambda gateway: gateway.parts[Schedules].replace(robot[1:], body, UNLIMITED),
        )

    async def remove_schedules(self) -> None:
        """Remove all schedules, if a gateway is there."""

        async def remove(gateway: "Gateway") -> None:
            for document in await gateway.parts[Schedules].documents():
                await gateway.parts[Schedules].remove(document["id"])

        await self._ask("remove the schedules", remove)

    async def repair_docks(self) -> None:
        """Say that all docks are in order."""
        self._say("people", "repair the docks")
        repair_docks(self._world.disk)

    async def change_batteries(self) -> None:
        """Give robots other batteries that are nearly empty."""
        for robot in self._world.robots.values():
            if robot.charge < 0.05:
                self._say("people", f"change the battery of {robot.name}")
                robot.change_battery()
                robot.switch_on()

    async def clear_docks(self) -> None:
        """Send the robots away that stand at docks and do not have to charge, if others may wait for those."""
        charging = {mission.robot for mission in self._checks.stored().values() if mission.recharge is not None}
        for robot in self._world.robots.values():
            if robot.dock is not None and not robot.running() and robot.name not in charging:
                await self._send(robot.servers["undock"].name, {})

    async def meddle(self) -> None:
        """Do something with a mission or a goal."""
        missions = self._checks.stored()
        if not missions:
            return
        mission_id = self._random.choice(sorted(missions))
        mission = missions[mission_id]
        if mission.status is MissionStatus.HELD:
            ways: list[Way] = [self.go_on, self._skip, self.cancel]
            weights = [10, 2, 1]
        else:
            ways, weights = [self._pause, self._cancel_goal, self.cancel], [5, 3, 1]
        await self._random.choices(ways, weights)[0](mission_id, mission)

    async def go_on(self, mission_id: str, mission: MissionEntry) -> None:
        self._checks.allowed(mission_id, robot_of(mission))
        await self._ask(f"continue {mission_id}", lambda gateway: gateway.missions.resume(mission_id, UNLIMITED))

    async def _skip(self, mission_id: str, mission: MissionEntry) -> None:
        self._checks.allowed(mission_id, robot_of(mission))
        await self._ask(f"skip {mission_id}", lambda gateway: gateway.missions.skip(mission_id, UNLIMITED))

    async def cancel(self, mission_id: str, mission: MissionEntry) -> None:
        self._checks.allowed(mission_id, robot_of(mission))
        await self._ask(f"cancel {mission_id}", lambda gateway: gateway.missions.cancel(mission_id, UNLIMITED))

    async def _pause(self, mission_id: str, _: MissionEntry) -> None:
        self._checks.paused(mission_id)
        await self._ask(f"pause {mission_id}", lambda gateway: gateway.missions.pause(mission_id, UNLIMITED))

    async def _cancel_goal(self, _: str, mission: MissionEntry) -> None:
        async def cancel(gateway: "Gateway") -> None:
            for goal in gateway.actions.running():
                action = gateway.actions.get(goal.action_name)
                if action is not None and goal.goal_id == mission.current.goal_id:
                    await action.canceler.cancel(goal)

        await self._ask("cancel a goal", cancel)

    async def send_goal(self) -> None:
        name = self._random.choice(sorted(self._world.servers))
        message = {}
        if "connect_to" in name:
            message = {"desired_battery_state": {"location": self._random.choice(self._world.docks.names)}}
        await self._send(name, message)

    async def _send(self, name: str, message: dict[str, Any]) -> None:
        async def send(gateway: "Gateway") -> None:
            action = gateway.actions.get(name)
            if action is not None:
                await action.submitter.submit(message, sender=ANYBODY)

        await self._ask(f"send a goal to {name}", send)

    async def continue_rule(self) -> None:
        """Let the rule go on with a robot that may have been stopped."""
        robot, began = self._random.choice(self._world.ruled), self._world.time
        ask: Ask = lambda gateway: gateway.rules.last_stops.allow(robot)  # noqa: E731 - of one line
        if await self._ask(f"continue the rule for {robot}", ask):
            self._checks.rules.continued(robot, began)

    async def stop(self) -> None:
        robot = self._random.choice([None, *self._world.names, *self._world.names])
        latch = self._random.random() < 0.6
        robots = [] if robot is None else [robot]
        began = self._world.time
        self._checks.groups.disturbed(robots or self._world.names)
        if await self._ask(f"stop {robot}, latch {latch}", lambda gateway: gateway.stopper.stop(*robots, latch=latch)):
            self._checks.stopped(robots or self._world.names, began)
        if latch:
            self._world.chance.spawn(self._release_later(robot))

    async def _release_later(self, robot: str | None) -> None:
        await asyncio.sleep(self._random.choice([0.5, 30.0, 600.0]))
        await self._insist(f"release {robot}", lambda gateway: gateway.stopper.release(robot))
        self._released(robot)

    async def release(self, robot: str | None) -> None:
        """Release a stop, if a gateway is there."""
        if await self._ask(f"release {robot}", lambda gateway: gateway.stopper.release(robot)):
            self._released(robot)

    def _released(self, robot: str | None) -> None:
        robots = self._world.names if robot is None else [robot]
        self._checks.groups.disturbed(robots)
        self._checks.rules.released(robots)
