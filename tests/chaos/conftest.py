"""An action server that notes what it executes."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.processes import ForkedProcess, ros_environment


@pytest.fixture
def executed(domain: int, tmp_path: Path) -> Iterator[Path]:
    """What the action server notes of each goal that it executes."""
    notes = tmp_path / "executed"
    command = ("-m", "tests.support.busy_action_server", "--executed", str(notes))
    with ForkedProcess(*command, env=ros_environment(domain)) as process:
        process.wait_for("serving")
        yield notes
