"""Dock all robots at the same time: `python examples/fleet.py`."""

import asyncio

from dock_gateway.client import AsyncClient


async def main() -> None:
    async with AsyncClient() as gateway:
        names = [robot.name for robot in await gateway.robots() if robot.dock]
        goals = [await gateway.dock(robot=name) for name in names]
        for name, end in zip(names, await asyncio.gather(*(goal.wait() for goal in goals)), strict=True):
            print(name, end.status, end.error.detail if end.error else "")


asyncio.run(main())
