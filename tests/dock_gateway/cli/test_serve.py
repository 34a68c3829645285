"""`dock-gateway serve`: what cannot work is said before anything starts."""

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.start import check_installed
from dock_gateway.core.dock_adapters.catalog import ADAPTERS


@pytest.mark.parametrize("verb", ["dock", "undock"])
@pytest.mark.parametrize(
    "action_type", ["no_such_package/action/Dock", "action_tutorials_interfaces/action/Dock", "sensor_msgs/action/Dock"]
)
def test_an_action_that_is_not_installed(action_type: str, verb: str) -> None:
    result = CliRunner().invoke(main, ["serve", f"--{verb}-action-type", action_type])
    assert result.exit_code == 2
    assert f" {verb}_action_type: the ROS interfaces" in result.output
    assert "Traceback" not in result.output


def test_our_own_types_are_installed() -> None:
    for setting, adapters in ADAPTERS.items():
        check_installed(setting, adapters[0].action_type)
