"""A goal that was on its way when a stop came is canceled, however late the action server accepts it.

Each seed is a run of a minute in virtual time. `SIMULATION_SEEDS=10000` tries more of them, `SIMULATION_SEED=4711` one.
"""

import os

import pytest

from tests.dock_gateway.simulation.late_goals import LateGoals, Troubles
from tests.support.virtual import run

SEEDS = int(os.environ.get("SIMULATION_SEEDS", "60"))
ONLY = os.environ.get("SIMULATION_SEED")

CASES = {
    "a calm network": Troubles(),
    "slow": Troubles(latency=2.0),
    "frozen": Troubles(frozen=8.0),
    "frozen and released": Troubles(frozen=8.0, released_after=4.0),
    "frozen for longer than the gateway waits": Troubles(frozen=20.0, released_after=4.0, accept_timeout=0.5),
    "not latched": Troubles(frozen=4.0, latched=False),
    "not latched, answers are lost": Troubles(frozen=4.0, latched=False, answers_lost=0.3),
    "answers are lost, released": Troubles(frozen=4.0, released_after=1.0, answers_lost=0.3),
    "slow, answers are lost, not latched": Troubles(latency=2.0, latched=False, answers_lost=0.3),
    "at another gateway": Troubles(frozen=4.0, by_another=True),
    "at another gateway, released": Troubles(frozen=8.0, by_another=True, released_after=0.5),
    "at another gateway, released later": Troubles(frozen=8.0, by_another=True, released_after=4.0, answers_lost=0.3),
    "refused at first": Troubles(refusals=3, latency=0.1, answers_lost=0.2),
}
# Seconds after the stop, the acceptance or the end of the freezing, whichever is last: a cancel request whose answer is
# lost is repeated after its timeout of 1 s and a pause of 1 s; each message takes its time.
WITHIN = 30.0


@pytest.mark.parametrize("case", CASES)
def test_no_goal_from_before_a_stop_runs(case: str) -> None:
    seeds = range(max(1, SEEDS // 4)) if ONLY is None else [int(ONLY)]
    took, late = [], 0
    for seed in seeds:
        world = LateGoals(seed, CASES[case])
        run(world.run())
        assert world.found() == [], f"SIMULATION_SEED={seed}"
        took += world.took()
        late += world.late()
    longest = max(took)
    print(f"{len(took)} goals canceled in {len(seeds)} runs within {longest:.2f} s, {late} accepted after the stop")
    assert longest < WITHIN
