"""A goal is canceled soon after its robot is back from an outage in which DDS has lost sight of it."""

import json
import os
import shutil
import subprocess
import sys
import time
from typing import Any

import pytest

from dock_gateway.goals.rejoining import KEEP, PAUSE
from tests.chaos.report import report
from tests.chaos.withstand import STOPPED_WITHIN
from tests.support.gateway import IMPATIENT, running_gateway, running_hostile_node
from tests.support.probe import open_files, probing, quantile

ROUNDS = int(os.environ.get("CHAOS_OUTAGES", "0"))
pytestmark = [
    pytest.mark.ros,
    pytest.mark.timeout(3600),
    pytest.mark.skipif(not ROUNDS, reason="an outage takes half a minute: `make chaos`, or CHAOS_OUTAGES=5"),
]

ROBOTS = 5
# How long servers that stop answering are watched.
SECONDS = 90


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
        "healthz, worst, ms": round(1000 * lines[-1]["healthz"]),
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
    assert figures["healthz, worst, ms"] < 1000 * STOPPED_WITHIN


def test_servers_that_stop_answering_harm_no_other(domain: int) -> None:
    """They send feedback, so each may be one whose answers get lost. That must not cost other robots anything."""
    with running_gateway(domain, **IMPATIENT) as gateway:
        files = open_files(gateway.process.pid)
        with running_hostile_node(domain, "silent_servers", "--count", "20", "--rate", "0.5"):
            gateway.process.wait_for("another DDS participant is tried")
            with probing(gateway) as findings:
                time.sleep(SECONDS)
            more_files = open_files(gateway.process.pid) - files
        tries = gateway.process.output.count("another DDS participant is tried")
    figures = {"tries": tries, "files opened": more_files, **findings.figures()}
    report("Outages: 20 servers that send feedback and answer nothing", figures)
    assert findings.errors == []
    assert tries <= 20 * (2 + SECONDS / (KEEP + 2 * PAUSE))
    assert quantile(findings.stop, 0.99) < STOPPED_WITHIN
    assert max(findings.gaps) < 2 * STOPPED_WITHIN
    assert more_files < 200
