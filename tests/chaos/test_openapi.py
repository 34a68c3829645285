"""Everything that the OpenAPI document says holds for the running gateway, and nothing that it forbids is accepted."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.chaos.report import report
from tests.support.gateway import running_gateway, running_program
from tests.support.processes import BIN

pytestmark = [pytest.mark.ros, pytest.mark.timeout(3600)]

# Requests for each operation, besides those that are derived from the document.
EXAMPLES = os.environ.get("CHAOS_EXAMPLES", "1")
SEED = os.environ.get("CHAOS_SEED", "1")


def test_the_gateway_does_what_its_document_says(domain: int, tmp_path: Path) -> None:
    """A simulated robot obeys meanwhile: it docks, is stopped, put elsewhere, and its battery falls silent."""
    folder = Path(__file__).parent
    with (
        running_program(domain, "dock_simulator"),
        running_program(domain, "docking_server", "-p", "controller:=dock_pose", "-p", "goal_timeout:=2.0"),
        running_gateway(domain) as gateway,
    ):
        gateway.wait_until_ready()
        command = [str(BIN / "schemathesis"), "--config-file", str(folder / "schemathesis.toml"), "run"]
        options = ["--max-examples", EXAMPLES, "--seed", SEED, "--no-color"]
        run = subprocess.run(
            [*command, f"{gateway.url}/openapi.json", *options],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(folder.parents[1])},
            capture_output=True,
            text=True,
            check=False,
        )
        assert run.returncode == 0, run.stdout + run.stderr
        assert "Traceback" not in gateway.process.output
    figures = re.search(r"(\d+) generated, (.+)", run.stdout)
    assert figures is not None, run.stdout
    report("OpenAPI", {"requests": figures[1], "result": figures[2], "seed": SEED})
