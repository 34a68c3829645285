"""The pages about docking and the simulator list all that there is, and nothing else."""

import re

import pytest
from scripts.docking_tables import DOCS, NAV2_PAGE, PAGES, written

from docking.clients.session import ExitCode
from docking.core.errors import ErrorCode, Stage
from docking.goal.report import LEVELS
from docking.simulation.faults import Fault

GUIDE = (DOCS / "docking.md").read_text()
REFERENCE = (DOCS / "docking-reference.md").read_text()
SIMULATOR = (DOCS / "simulator.md").read_text()


def rows(heading: str, page: str = REFERENCE) -> list[list[str]]:
    """The cells of the table that follows a line."""
    lines = page.split(heading, 1)[1].split("|---", 1)[1].splitlines()[1:]
    table = lines[: next((n for n, line in enumerate(lines) if not line.startswith("|")), len(lines))]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


@pytest.mark.parametrize("name", [*PAGES, NAV2_PAGE])
def test_every_parameter_is_documented(name: str) -> None:
    assert written(name) == (DOCS / name).read_text(), "write the tables anew: make format"


def test_every_stage_is_documented_with_its_level() -> None:
    assert {row[0]: row[1] for row in rows("| stage |")} == {f"`{stage}`": LEVELS[stage].name for stage in Stage}


def test_every_error_code_is_documented_with_its_number() -> None:
    assert [row[:2] for row in rows("| error_code |")] == [[f"`{code}`", f"{code.number}"] for code in ErrorCode]


def test_every_fault_of_the_simulator_is_documented() -> None:
    assert [row[0] for row in rows("| fault |", SIMULATOR)] == [f"`{fault}`" for fault in Fault]


def test_every_exit_code_is_documented() -> None:
    assert {int(row[0]) for row in rows("| exit code |")} == {*ExitCode, 2}


def test_every_option_of_the_clients_is_documented() -> None:
    assert set(re.findall(r"\[(--[a-z]+) ", GUIDE)) == {"--voltage", "--percentage", "--status", "--timeout", "--order"}
