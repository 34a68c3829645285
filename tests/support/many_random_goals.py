"""Runs many random goals and counts those that end within the sum of their limits: far more than the tests do.

    python -m tests.support.many_random_goals --goals 100000

The even ones have a plan that does anything (each twelfth undocks), the odd ones a plan of ours.
"""

import argparse
import sys
from collections import Counter
from random import Random
from time import monotonic

from docking.goal.outcome import Outcome
from tests.support.random_goals import docking_goal, real_plan, run, undocking_goal

EACH = 1000
"""After so many goals, and at the end, it says what it has counted."""


def run_one(seed: int) -> tuple[str, float, Outcome | None]:
    """Run the goal of a seed: its kind, the seconds beyond its longest time, and its outcome."""
    random = Random(f"many {seed}")
    if seed % 12 == 0:
        return "undocking", *run(undocking_goal(random), random)
    if seed % 2 == 0:
        return "any plan", *run(docking_goal(random), random)
    return "our plans", *run(docking_goal(random, real_plan(random)), random)


def main() -> int:
    """Run them; the exit code is 1 where one has not ended."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--goals", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="no goal begins after this")
    args = parser.parse_args()
    kinds, ends, latest, endless, began = Counter[str](), Counter[str](), float("-inf"), list[int](), monotonic()
    for number, seed in enumerate(range(args.first, args.first + args.goals), start=1):
        kind, beyond, outcome = run_one(seed)
        kinds[kind] += 1
        if outcome is None:
            endless.append(seed)
        else:
            ends[f"{outcome.end.value} {outcome.error_code.value}"] += 1
            latest = max(latest, beyond)
        over = monotonic() - began > args.seconds
        if over or number % EACH == 0 or number == args.goals:
            print(
                f"{number} goals, {len(endless)} without an end {endless[:9]}, at most {latest:.1f} s beyond",
                kinds,
                ends,
            )
            sys.stdout.flush()
        if over:
            break
    return 1 if endless else 0


if __name__ == "__main__":
    sys.exit(main())
