"""The programs that users start: what ROS lacks ends one in a sentence."""

import sys
from pathlib import Path

import pytest

from docking.programs import EXIT_UNUSABLE, main


def refusal(capsys: pytest.CaptureFixture[str]) -> str:
    """Return the sentence with which a start ends."""
    assert main() == EXIT_UNUSABLE
    (sentence,) = capsys.readouterr().err.splitlines()
    return sentence


@pytest.mark.parametrize(("variable", "value"), [("ROS_DOMAIN_ID", "233"), ("RMW_IMPLEMENTATION", "rmw_nonsense_cpp")])
def test_a_variable_that_is_wrong(
    variable: str, value: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(variable, value)
    assert f"`unset {variable}`" in refusal(capsys)


def test_without_rclpy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert "`make setup`" in refusal(capsys)


def test_interfaces_that_do_not_load(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    name = "action_tutorials_interfaces"
    monkeypatch.setitem(sys.modules, f"{name}.{name}_s__rosidl_typesupport_c", None)
    assert f"the ROS package {name} does not load" in refusal(capsys)
