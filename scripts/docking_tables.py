"""Writes the tables of parameters in docs/ anew, from the dataclasses that declare the parameters."""

from collections.abc import Iterable, Iterator
from itertools import chain, dropwhile
from pathlib import Path

from docking.core.parameter import NodeSettings, Parameter, named_parameters_of, parameters_of
from docking.parameters import DockSettings, UndockSettings
from docking.parameters.nav2_table import NAV2, Meaning, Nav2Parameter
from docking.simulation.parameters import SimulatorSettings
from docking.tutorial.fibonacci import FibonacciSettings

DOCS = Path(__file__).parents[1] / "docs"
PAGES: dict[str, dict[str, type[NodeSettings]]] = {
    "docking-reference.md": {
        "connect_to_charging_dock_action_server": DockSettings,
        "disconnect_from_charging_dock_action_server": UndockSettings,
        "fibonacci_action_server": FibonacciSettings,
    },
    "simulator.md": {"dock_simulator": SimulatorSettings},
}
HEAD = "| parameter | type | unit | range | default | |\n|---|---|---|---|---|---|\n"
NAV2_PAGE = "nav2.md"
NAV2_HEAD = "| nav2's parameter | nav2's default | here |\n|---|---|---|\n"
TYPES = {bool: "bool", int: "integer", float: "double"}


def row(parameter: Parameter) -> str:
    """The line about a parameter."""
    default, limits = parameter.default, f"`{parameter.form}`" if parameter.form else ""
    if parameter.minimum is not None:
        limits = f"{parameter.minimum:.10g} … {parameter.maximum:.10g}"
    elif parameter.choices:
        limits = ", ".join(f"`{choice}`" for choice in parameter.choices)
    if isinstance(default, bool):
        shown = f"`{str(default).lower()}`"
    elif isinstance(default, (str, tuple)):
        shown = f"`{default}`" if default else "empty"
    else:
        shown = f"{default:g}"
    kind = TYPES.get(type(default), "string")
    if parameter.elements is not None:
        kind = f"{TYPES.get(parameter.elements, 'string')} array"
    cells = (f"`{parameter.name}`", kind, parameter.unit, limits, shown, parameter.text)
    return f"| {' | '.join(cells)} |\n".replace("|  |", "| |")


def rows(settings: type[NodeSettings]) -> Iterator[str]:
    """The lines about all parameters of a node; those of each dock have `<dock>` as its name."""
    parameters = list(parameters_of(settings))
    values = {parameter.name: parameter.default for parameter in parameters} | {"docks": ("<dock>",)}
    yield from map(row, chain(parameters, named_parameters_of(settings, values)))


def nav2_row(parameter: Nav2Parameter) -> str:
    """The line about a parameter of nav2."""
    default = parameter.default
    shown = "" if default is None else f"`{str(default).lower() if isinstance(default, bool) else default}`"
    accepted = " or ".join(f"`{str(one).lower() if isinstance(one, bool) else one}`" for one in parameter.accepted)
    unless = f", unless it is {accepted.replace('``', 'empty')}" if accepted else ""
    here = {
        Meaning.SAME: "the same",
        Meaning.MAPPED: f"sets `{parameter.ours}`",
        Meaning.REFUSED: f"refused{unless}",
        Meaning.IGNORED: f"ignored with a warning{unless}",
    }[parameter.meaning]
    differs = parameter.differs if parameter.meaning is not Meaning.REFUSED else ""
    parts = [here, parameter.text, differs and f"here the default is `{differs}`"]
    told = parameter.meaning in {Meaning.REFUSED, Meaning.IGNORED}
    text = (": " if told else "; ").join(part for part in parts if part)
    return f"| `{parameter.name}` | {shown if default != '' else 'empty'} | {text} |\n".replace("|  |", "| |")


def with_table(page: str, heading: str, head: str, lines: Iterable[str]) -> str:
    """A page, with the table below a heading made anew."""
    before, heading, after = page.partition(heading)
    between, _, rest = after.partition(head)
    after_table = list(dropwhile(lambda line: line.startswith("|"), rest.splitlines(keepends=True)))
    return "".join([before, heading, between, head, *lines, *after_table])


def written(name: str) -> str:
    """A page, with its tables made anew."""
    page = (DOCS / name).read_text()
    for node, settings in PAGES.get(name, {}).items():
        page = with_table(page, f"## {node}\n", HEAD, rows(settings))
    if name == NAV2_PAGE:
        page = with_table(page, "## Its parameter files\n", NAV2_HEAD, map(nav2_row, NAV2))
    return page


if __name__ == "__main__":
    for name in (*PAGES, NAV2_PAGE):
        (DOCS / name).write_text(written(name))
