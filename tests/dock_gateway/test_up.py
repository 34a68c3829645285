"""`dock-gateway up`: where it says that the gateway is."""

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.up import own_url
from dock_gateway.settings import Settings


@pytest.mark.parametrize(
    ("host", "url"),
    [
        ("127.0.0.1", "http://127.0.0.1:8000"),
        ("0.0.0.0", "http://127.0.0.1:8000"),
        ("::1", "http://[::1]:8000"),
        ("::", "http://[::1]:8000"),
        ("robot.local", "http://robot.local:8000"),
    ],
)
def test_the_address_that_is_announced(host: str, url: str) -> None:
    assert own_url(Settings(host=host)) == url


def test_a_port_that_cannot_be_announced_is_refused() -> None:
    result = CliRunner().invoke(main, ["up", "--port", "0"])
    assert result.exit_code == 2
    assert "needs a port other than 0" in result.output
