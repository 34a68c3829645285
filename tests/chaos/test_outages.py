"""A goal is canceled soon after its robot is back from an outage in which DDS has lost sight of it."""

import json
import os
import shutil
import subprocess
import sys
from typing import Any

import pytest

from tests.chaos.report import report

ROUNDS = int(os.environ.get("CHAOS_OUTAGES", "0"))
pytestmark = [
    pytest.mark.ros,
    pytest.mark.timeout(3600),
    pytest.mark.skipif(not ROUNDS, reason="an outage takes half a minute: `make chaos`, or CHAOS_OUTAGES=5"),
]

ROBOTS = 5


def outages(kind: str, seconds: float, spread: float) -> dict[str, Any]:
    """Have so many outages; return what they took."""
    if shutil.which("unshare") is None or shutil.which("tc") is None:
        pytest.skip("there is no `unshare` or no `tc`")
    command = ("unshare", "--map-root-user", "--net", sys.executable, "-m", "tests.chaos.outages")
    arguments = (str(ROUNDS), str(min(ROBOTS, ROUNDS)), kind, str(seconds), str(spread))
    done = subprocess.run((*command, *arguments), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    results = [line for line in lines if "took" in line]
    assert len(results) == ROUNDS, done.stderr
    took = sorted(result["took"] for result in results)
    return {
        "outages": len(results),
        "not canceled": sum(result["status"] != "canceled" for result in results),
        "canceled after, median / worst, s": f"{took[len(took) // 2]:.1f} / {took[-1]:.1f}",
        "later than 5 s": sum(seconds > 5 for seconds in took),
        "through another participant": lines[-1]["rejoined"],
    }


def test_frozen_for_22_s() -> None:
    figures = outages("freeze", 22, 0)
    report("Outages: action server frozen for 22 s", figures)
    assert figures["not canceled"] == figures["later than 5 s"] == 0


def test_out_of_the_wifi() -> None:
    """Between 18 and 21 s one side may have removed the other while the other has not."""
    figures = outages("link", 18.2, 2.5)
    report("Outages: nothing passes for 18 to 21 s", figures)
    assert figures["not canceled"] == 0
