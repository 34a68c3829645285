"""The setting that lets agents in."""

import sys

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main


@pytest.mark.parametrize("command", ["serve", "up"])
def test_agents_without_what_speaks_their_protocol(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mcp", None)
    result = CliRunner().invoke(main, [command, "--mcp"])
    assert result.exit_code == 2
    assert "dock-gateway[mcp] is not installed" in result.output
