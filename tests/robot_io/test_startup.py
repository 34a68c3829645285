"""What keeps ROS from starting."""

import sys
from pathlib import Path

import pytest

from robot_io.startup import find_load_fault


def test_a_sourced_installation_whose_libraries_are_not_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    prefix = tmp_path / "installation"
    site = prefix / "lib/python3/site-packages"
    site.joinpath("rclpy").mkdir(parents=True)
    site.joinpath("rclpy/__init__.py").write_text("raise ImportError('librcl.so: cannot open shared object file')")
    monkeypatch.syspath_prepend(site)
    for name in [*sys.modules]:
        if name.partition(".")[0] == "rclpy" or name == "robot_io.rclpy_private":
            monkeypatch.delitem(sys.modules, name)
    assert f"`source {prefix}/setup.bash`" in (find_load_fault({}) or "")
    tmp_path.joinpath("setup.bash").touch()  # as in a workspace, which has a folder for each package
    assert f"`source {tmp_path}/setup.bash`" in (find_load_fault({}) or "")
