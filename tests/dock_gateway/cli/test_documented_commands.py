"""The commands, options and variables that the pages name are there, and each command is on a page."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from dock_gateway.cli import COMMANDS, main
from dock_gateway.cli.options import TYPE
from dock_gateway.setting_groups.group import PREFIX
from dock_gateway.settings import unknown_variables
from dock_hub.settings import hub_settings_type

ROOT = Path(__file__).parents[3]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINE = re.compile(r"^\$ (?!docker build|docker run)(.*\bdock-gateway .*?)(?:\s{2,}#.*)?$", re.MULTILINE)
# Of docker-compose.proxy.yml, and of the example of an extension.
OTHERS = {f"{PREFIX}{name}" for name in ("HTTPS_PORT", "SITE", "SITE_TLS", "ODOMETER_SERVICE_KM")}
VARIABLE = re.compile(rf"\b{PREFIX}[A-Z0-9_]*[A-Z0-9]\b")


def lines() -> Iterator[tuple[str, list[str]]]:
    """The command lines of all pages, without what comes after a pipe."""
    for page in PAGES:
        for found in LINE.findall(page.read_text()):
            words = shlex.split(re.split(r" [|>&] |…", found)[0])
            at = next((at for at, word in enumerate(words) if word.rpartition("/")[2] == "dock-gateway"), None)
            if at is not None:
                yield f"{page.name}: {found}", words[at + 1 :]


@pytest.mark.parametrize(("place", "arguments"), [pytest.param(*each, id=each[0]) for each in lines()])
def test_a_command_line_of_a_page_can_be_read(place: str, arguments: list[str]) -> None:
    command: click.Command = main
    context = click.Context(main)
    while isinstance(command, click.Group) and arguments and not arguments[0].startswith("-"):
        name, found, arguments = command.resolve_command(context, arguments)
        assert found is not None, place
        command, context = found, click.Context(found, parent=context, info_name=name)
    known = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
    given = {word.partition("=")[0] for word in arguments if word.startswith("--")}
    assert given - known - {"--help", "--ros-args"} == set(), place


def test_each_variable_of_a_page_is_a_setting() -> None:
    fields = {*TYPE.model_fields, *hub_settings_type().model_fields}
    named = {variable for page in PAGES for variable in VARIABLE.findall(page.read_text())}
    assert unknown_variables(named - OTHERS, fields) == []


def test_each_command_is_on_a_page() -> None:
    text = "\n".join(page.read_text() for page in PAGES)
    assert [name for name in COMMANDS if not re.search(rf"(dock-gateway |`){name}\b", text)] == []
