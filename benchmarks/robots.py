"""Case (f): many robots, each in its namespace with feedback at 10 Hz, through one gateway."""

import asyncio
import time

from benchmarks.cases import add_readings
from benchmarks.figures import BARE, OURS, Results
from benchmarks.machine import wait_until_quiet
from benchmarks.options import Options
from benchmarks.site import ACTION, Goal, site
from benchmarks.systems.bare import Bare
from benchmarks.systems.base import Impossible
from benchmarks.systems.gateway import Gateway

RATE = 10
DISCOVERY = 60.0


async def robots(results: Results, options: Options) -> None:
    """One goal on each robot, all feedback read by one reader."""
    case = f"(f) {options.robots} robots x {RATE} Hz"
    # Goals go out one after another: a delay lets all of them be there before the first feedback.
    goal = Goal(RATE, int(RATE * options.seconds), 4.0)
    with site(options.payload, options.robots) as where:
        client = Bare(where)
        try:
            await client.start_idle()
            order = {"do": "robots", "robots": options.robots, "goal": goal.state}
            await client.read({**order, "goal": Goal(RATE, 1).state}, Goal(RATE, 1), options.robots)
            wait_until_quiet(options.quiet)
            add_readings(results, case, BARE, [await client.read(order, goal, options.robots)])
        finally:
            await client.close()
    with site(options.payload, options.robots) as where:
        gateway = Gateway(where)
        try:
            await gateway.start_idle()
            begun = time.monotonic()
            names = await _discover(gateway, options.robots)
            results.add(case, "start → all actions known", OURS, time.monotonic() - begun, unit="s")
            wait_until_quiet(options.quiet)
            reading = await gateway.read(goal, 1, [f"/actions{name}/goals" for name in names])
            add_readings(results, case, OURS, [reading])
            results.add(case, "RSS", OURS, gateway.rss, unit="MB")
        except (Impossible, TimeoutError, AssertionError) as why:
            results.missing(case, "", OURS, str(why)[:300] or type(why).__name__)
        finally:
            await gateway.close()


async def _discover(gateway: Gateway, count: int) -> list[str]:
    wanted = [f"/robot{number}/{ACTION}" for number in range(1, count + 1)]
    deadline = time.monotonic() + DISCOVERY
    while time.monotonic() < deadline:
        known = await asyncio.to_thread(gateway.actions)
        if known is None:
            raise Impossible("needs /actions")
        if set(wanted) <= set(known):
            return wanted
        await asyncio.sleep(0.1)
    raise Impossible(f"only {len(set(wanted) & set(known))} of {count} actions were known after {DISCOVERY:g} s")
