"""Whatever is killed, late or slow: a reader that moves between gateways is told the end of each goal exactly once.

Where gateways share a database, that goes for every state of a goal.

Each seed is a run of some seconds in virtual time. `SIMULATION_SEEDS=10000` tries more of them, `SIMULATION_SEED=4711`
tries one, with all that happened.
"""

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeVar

import pytest

from tests.dock_gateway.simulation.chance import Faults
from tests.dock_gateway.simulation.database import Disk
from tests.dock_gateway.simulation.gateway import simulated
from tests.dock_gateway.simulation.sites_world import SitesWorld
from tests.dock_gateway.simulation.world import World
from tests.support.virtual import run

WorldT = TypeVar("WorldT", bound=World)

pytestmark = pytest.mark.timeout(3600)

SEEDS = int(os.environ.get("SIMULATION_SEEDS", "60"))
ONLY = os.environ.get("SIMULATION_SEED")

HARSH = Faults(kills=4, moves=6)
CASES = {
    "killed, late and slow": Faults(),
    "killed again and again": HARSH,
    "killed while the database answers at once": replace(HARSH, stall=0.0),
    "a single gateway": replace(HARSH, gateways=1),
}


@pytest.fixture(scope="module")
def disk() -> Disk:
    return Disk()


async def run_of(make: Callable[[], WorldT]) -> WorldT:
    world = make()
    await world.run()
    return world


def seeds_of_case() -> Sequence[int]:
    """Return the seeds for each of the five cases."""
    return range(SEEDS // 5) if ONLY is None else [int(ONLY)]


def check(world: World, seed: int) -> int:
    """Check what a reader got; return the number of goals."""
    if ONLY is not None or world.faults_found():
        print(world.story())
    assert world.faults_found() == [], f"SIMULATION_SEED={seed}"
    assert world.server.goals
    return len(world.server.goals)


@pytest.mark.parametrize("case", CASES)
def test_each_end_is_told_once(disk: Disk, case: str) -> None:
    seeds = seeds_of_case()
    goals = 0
    with simulated():
        for seed in seeds:
            goals += check(run(run_of(partial(World, seed, disk, CASES[case]))), seed)
    print(goals, "goals in", len(seeds), "runs")


def test_each_end_is_told_once_at_a_hub(disk: Disk) -> None:
    seeds = seeds_of_case()
    goals, counts = 0, Counter[str]()
    hub_disk = Disk()
    with simulated():
        for seed in seeds:
            world = run(run_of(partial(SitesWorld, seed, disk, hub_disk, replace(HARSH, gateways=1))))
            goals += check(world, seed)
            counts += Counter(lost=world.nats.lost, repeated=world.nats.repeated, reordered=world.nats.reordered)
    print(goals, "goals in", len(seeds), "runs; messages of the broker:", dict(counts))
