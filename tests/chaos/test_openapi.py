"""Everything that the OpenAPI document says holds for the running gateway, and nothing that it forbids is accepted."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.chaos.report import report
from tests.support.access import Site
from tests.support.gateway import running_gateway, running_program
from tests.support.processes import BIN

pytestmark = [pytest.mark.ros, pytest.mark.timeout(3600)]

# Requests for each operation, besides those that are derived from the document.
EXAMPLES = os.environ.get("CHAOS_EXAMPLES", "1")
SEED = os.environ.get("CHAOS_SEED", "1")
THOROUGH = EXAMPLES != "1"
# Random requests are for `make chaos`: each costs more than all that the document suggests for its operation.
PHASES = "examples,coverage,fuzzing,stateful" if THOROUGH else "examples,coverage"


def schemathesis(folder: Path, url: str, *options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Send what the document of a gateway allows, and what it does not."""
    here = Path(__file__).parent
    command = [
        str(BIN / "schemathesis"),
        "--config-file",
        str(here / "schemathesis.toml"),
        "run",
        f"{url}/openapi.json",
        "--suppress-health-check=filter_too_much",  # a name that is there is seldom made up
    ]
    return subprocess.run(
        [*command, "--max-examples", EXAMPLES, "--seed", SEED, "--no-color", *options],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(here.parents[1]), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_gateway_does_what_its_document_says(domain: int, tmp_path: Path) -> None:
    """A simulated robot obeys meanwhile: it docks, is stopped, put elsewhere, and its battery falls silent."""
    with (
        running_program(domain, "dock_simulator"),
        running_program(domain, "docking_server", "-p", "controller:=dock_pose", "-p", "goal_timeout:=2.0"),
        running_gateway(domain, server_wait="1") as gateway,  # for services, too, of which made up ones are not there
    ):
        gateway.wait_until_ready()
        gateway.http.get("/openapi.json").raise_for_status()  # it is made once: schemathesis waits for 10 s at most
        run = schemathesis(tmp_path, gateway.url, "--phases", PHASES)
        assert run.returncode == 0, run.stdout + run.stderr
        assert "Traceback" not in gateway.process.output
    figures = re.search(r"(\d+) generated, (.+)", run.stdout)
    assert figures is not None, run.stdout
    report("OpenAPI", {"requests": figures[1], "result": figures[2], "seed": SEED})


@pytest.mark.skipif(
    not THOROUGH, reason="for make chaos; tests/dock_gateway/access/test_authorization.py proves it, too"
)
def test_without_credentials_nothing_is_carried_out(domain: int, tmp_path: Path) -> None:
    """Whatever is sent: no 2xx but for health checks, the login and who one is."""
    with Site(tmp_path).gateway(domain) as gateway:
        options = ("--phases", "coverage,fuzzing", "--checks", "refused_without_token")
        run = schemathesis(tmp_path, gateway.url, *options, WITHOUT_CREDENTIALS="yes")
        assert run.returncode == 0, run.stdout + run.stderr
        assert gateway.http.get("/session").json()["principal"] is None
        assert "Traceback" not in gateway.process.output
    assert re.search(r"[1-9]\d+ generated", run.stdout), run.stdout
