"""Whatever is killed, late or slow: a reader that moves between gateways is told the end of each goal exactly once.

Each seed is a run of some seconds in virtual time. `SIMULATION_SEEDS=10000` tries more of them, `SIMULATION_SEED=4711`
tries one, with all that happened.
"""

import os
from dataclasses import replace

import pytest

from tests.dock_gateway.simulation.chance import Faults
from tests.dock_gateway.simulation.database import Disk
from tests.dock_gateway.simulation.gateway import simulated
from tests.dock_gateway.simulation.virtual import run
from tests.dock_gateway.simulation.world import World

pytestmark = pytest.mark.timeout(3600)

SEEDS = int(os.environ.get("SIMULATION_SEEDS", "60"))
ONLY = os.environ.get("SIMULATION_SEED")

HARSH = Faults(kills=4, moves=6)
CASES = {
    "killed, late and slow": Faults(),
    "killed again and again": HARSH,
    "a single gateway": replace(HARSH, gateways=1),
}


@pytest.fixture(scope="module")
def disk() -> Disk:
    return Disk()


async def run_of(seed: int, disk: Disk, faults: Faults) -> World:
    world = World(seed, disk, faults)
    await world.run()
    return world


@pytest.mark.parametrize("case", CASES)
def test_each_end_is_told_once(disk: Disk, case: str) -> None:
    seeds = range(SEEDS // len(CASES)) if ONLY is None else [int(ONLY)]
    goals = 0
    with simulated():
        for seed in seeds:
            world = run(run_of(seed, disk, CASES[case]))
            if ONLY is not None or world.faults_found():
                print(world.story())
            assert world.faults_found() == [], f"SIMULATION_SEED={seed}"
            goals += len(world.server.goals)
    print(goals, "goals in", len(seeds), "runs")
    assert goals
