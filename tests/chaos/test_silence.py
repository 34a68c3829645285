"""A robot whose base has no command timeout stands still soon after the process that drives it has died or frozen."""

import json
import os
import subprocess
import sys
from collections import Counter

import pytest

from tests.chaos.report import report

MOMENTS = int(os.environ.get("CHAOS_MOMENTS", "4"))
SEED = int(os.environ.get("CHAOS_SEED", "1"))
pytestmark = [pytest.mark.ros, pytest.mark.timeout(7200)]

NAMESPACE = ("unshare", "--map-root-user", "--net")


def test_a_robot_without_a_command_timeout_stands_still_after_any_death() -> None:
    command = (*NAMESPACE, sys.executable, "-m", "tests.chaos.deaths", str(MOMENTS), str(SEED))
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    print(done.stdout)
    assert done.returncode == 0, done.stderr
    deaths = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    assert len(deaths) == MOMENTS
    ways = sorted(death["went"] for death in deaths if death["went"] is not None)
    wrong = [fault for death in deaths for fault in death["wrong"]]
    shares = (ways[min(len(ways) - 1, int(share * len(ways)))] for share in (0.5, 0.99, 1.0))
    figures = {
        **Counter(death["death"] for death in deaths),
        "while it was driven": len(ways),
        "went on, median / p99 / worst, m": " / ".join(f"{way:.3f}" for way in shares),
        "too far": len(wrong),
    }
    report("Deaths of one process, base without a command timeout", figures)
    assert ways
    assert wrong == []
