"""Writes the tables of parameters in docs/ anew, from the dataclasses that declare the parameters."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from docking.core.parameter import NodeSettings, Parameter, named_parameters_of, parameters_of
from docking.parameters import DockSettings, UndockSettings
from docking.simulation.parameters import SimulatorSettings
from docking.tutorial.fibonacci import FibonacciSettings

DOCS = Path(__file__).parents[1] / "docs"
PAGES: dict[str, dict[str, type[NodeSettings]]] = {
    "docking.md": {
        "connect_to_charging_dock_action_server": DockSettings,
        "disconnect_from_charging_dock_action_server": UndockSettings,
        "fibonacci_action_server": FibonacciSettings,
    },
    "simulator.md": {"dock_simulator": SimulatorSettings},
}
HEAD = "| parameter | type | unit | range | default | |\n|---|---|---|---|---|---|\n"
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


def written(name: str) -> str:
    """A page, with the table below the heading of each of its nodes made anew."""
    page = (DOCS / name).read_text()
    for node, settings in PAGES[name].items():
        before, heading, after = page.partition(f"## {node}\n")
        between, _, rest = after.partition(HEAD)
        lines = rest.splitlines(keepends=True)
        while lines and lines[0].startswith("|"):
            del lines[0]
        page = "".join([before, heading, between, HEAD, *rows(settings), *lines])
    return page


if __name__ == "__main__":
    for name in PAGES:
        (DOCS / name).write_text(written(name))
