"""The rules that keep the core plain Python."""

from pathlib import Path

import pytest

from tests.docking.imports import MODULES, PACKAGE, ROS, ROS_PARTS, imported


@pytest.mark.parametrize("module", MODULES, ids=lambda module: str(module.relative_to(PACKAGE)))
def test_only_programs_import_ros_and_nothing_the_gateway(module: Path) -> None:
    names = imported(module)
    assert "dock_gateway" not in names
    if module.parent.name not in {"ros", "nodes", "clients", "tutorial"}:
        assert not names & (ROS | ROS_PARTS)
