"""A command that cannot be imported is missing, and takes no other with it."""

from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from dock_gateway import cli

SAID = "the commands of broken_commands cannot be imported: ModuleNotFoundError: No module named 'nothing'\n"


@pytest.fixture
def main(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> click.Group:
    """The command line with a broken module of an extension, and one of another program."""
    (tmp_path / "broken_commands.py").write_text("import nothing\n")
    (tmp_path / "extra_commands.py").write_text("import click\nCOMMANDS = (click.Command('extra', help='Do more.'),)\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(cli, "modules_of", lambda _: iter(("broken_commands", "extra_commands")))
    broken = EntryPoint("hub", "broken_commands:hub", cli.GROUP)
    monkeypatch.setattr(cli, "entry_points", lambda **wanted: EntryPoints([broken]).select(**wanted))
    return cli.LazyGroup("dock-gateway")


def test_the_help_has_all_others_and_says_so_once(main: click.Group) -> None:
    shown = CliRunner().invoke(main, ["--help"])
    assert shown.exit_code == 0, shown.output
    assert [name for name in (*cli.COMMANDS, "extra") if f"  {name} " not in shown.stdout] == []
    assert "  hub " not in shown.stdout
    assert shown.stderr == SAID + SAID.replace("commands of broken_commands", "command hub")


def test_all_others_work(main: click.Group) -> None:
    done = CliRunner().invoke(main, ["extra", "--help"])
    assert (done.exit_code, done.stderr) == (0, SAID)
    missing = CliRunner().invoke(main, ["hub"])
    assert (missing.exit_code, "No such command 'hub'" in missing.stderr) == (2, True)
    assert "the command hub cannot be imported" in missing.stderr
