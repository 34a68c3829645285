"""Whatever is killed, away, blocked or stopped: missions do each step once, in order, and none is forgotten.

Each seed is half an hour in virtual time. `SIMULATION_SEEDS=10000` tries more of them, `SIMULATION_SEED=4711` one,
with all that has happened. `SIMULATION_WEEKS=3` runs so many weeks with ten robots and four docks.
"""

import gc
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import pytest

from tests.dock_gateway.simulation.database import Disk
from tests.extensions.missions.simulation.gateway import simulated
from tests.extensions.missions.simulation.troubles import WEEK, Troubles
from tests.extensions.missions.simulation.world import World
from tests.support.virtual import run

pytestmark = pytest.mark.timeout(36_000)

SEEDS = int(os.environ.get("SIMULATION_SEEDS", "60"))
WEEKS = int(os.environ.get("SIMULATION_WEEKS", "0"))
ONLY = os.environ.get("SIMULATION_SEED")

CASES = {
    "one gateway": Troubles(),
    "two gateways": Troubles(gateways=2),
    "one that is killed again and again": Troubles(kills_every=60.0, kills_at_writes=0.01, kills_at_sends=0.2),
    "two that are killed again and again": Troubles(
        gateways=2, kills_every=60.0, kills_at_writes=0.01, kills_at_sends=0.2
    ),
    "stopped again and again": Troubles(gateways=2, stops_every=60.0, people_every=15.0),
    "robots that break": Troubles(servers_every=30.0, answers_lost=0.1),
    "missions for groups": Troubles(
        robots=5,
        docks=3,
        schedules=0,
        missions_every=1800.0,
        groups_every=75.0,
        stops_every=1200.0,
        goals_every=1800.0,
        kills_every=900.0,
    ),
    "robots that wait for one dock": Troubles(
        gateways=2,
        robots=5,
        docks=1,
        schedules=0,
        waiting_places=1.0,
        missions_every=120.0,
        groups_every=600.0,
        kills_every=600.0,
        servers_every=300.0,
    ),
    "rules of automatic docking": Troubles(
        gateways=2,
        robots=4,
        docks=3,
        schedules=0,
        rules=3,
        missions_every=500.0,
        groups_every=600.0,
        goals_every=150.0,
        kills_every=600.0,
        servers_every=300.0,
    ),
    "nothing goes wrong": Troubles(kills_every=1e9, kills_at_writes=0, kills_at_sends=0, servers_every=1e9),
}


@pytest.fixture(scope="module")
def disk() -> Iterator[Disk]:
    gc.freeze()  # what is imported is not looked at again in each collection: a tenth of the time of a run
    yield Disk()
    gc.unfreeze()


def world_of(seed: int, disk: Disk, troubles: Troubles) -> World:
    """Run a seed, and return the world in which it was."""
    worlds: list[World] = []

    async def go() -> None:
        worlds.append(World(seed, disk, troubles))
        await worlds[0].run()

    with simulated(troubles):
        run(go())
    (world,) = worlds
    return world


def carried_out(seed: int, disk: Disk, troubles: Troubles) -> Counter[str]:
    """Run a seed, check it, and return how often things have happened."""
    world = world_of(seed, disk, troubles)
    if ONLY is not None or world.checks.found:
        print(world.story())
    assert world.checks.found == [], f"SIMULATION_SEED={seed}"
    assert world.checks.counts["steps"]
    return world.checks.counts


@pytest.mark.parametrize("case", CASES)
def test_missions_do_each_step_once(disk: Disk, case: str) -> None:
    counts = Counter[str]()
    for seed in range(max(1, SEEDS // 20)) if ONLY is None else [int(ONLY)]:
        counts += carried_out(seed, disk, CASES[case])
    print(dict(counts))


TELL = """
from dataclasses import replace
from tests.extensions.missions.simulation.test_simulation import CASES, Disk, world_of

disk = Disk()
for case in ("stopped again and again", "two that are killed again and again"):
    print(world_of(3, disk, replace(CASES[case], lasts=300.0)).story())
"""


def test_a_seed_decides_everything() -> None:
    stories = []
    for hash_seed in ("1", "2"):  # by which sets are sorted
        told = subprocess.run(
            [sys.executable, "-c", TELL],
            env=os.environ | {"PYTHONHASHSEED": hash_seed},
            stdout=subprocess.PIPE,
            check=True,
            timeout=300,
        )
        stories.append(told.stdout.decode().splitlines())
    assert len(stories[0]) > 100
    assert stories[0] == stories[1]


@pytest.mark.skipif(not WEEKS, reason="takes minutes: SIMULATION_WEEKS=1 runs one")
def test_a_week_of_missions(disk: Disk) -> None:
    counts = Counter[str]()
    for seed in range(WEEKS) if ONLY is None else [int(ONLY)]:
        counts += carried_out(seed, disk, replace(WEEK, gateways=1 + seed % 2))
    print(dict(counts))
