"""Writes the table of settings in docs/configuration.md, from the settings and their descriptions: `make format`."""

from pathlib import Path

from dock_gateway.cli.options import FIELDS, ONLY_A_VARIABLE, option_name

PAGE = Path(__file__).parents[1] / "docs/configuration.md"
ROW = "| `DOCK_GATEWAY_"


def rows() -> list[str]:
    """Return the rows of the table: variable, option, default, description."""
    return [
        f"{ROW}{name.upper()}` | {_option(name)} | {_default(field.default)} | {field.description} |"
        for name, field in FIELDS
    ]


def _option(name: str) -> str:
    return "\N{EN DASH}" if name == ONLY_A_VARIABLE else f"`{option_name(name)}`"


def _default(default: object) -> str:
    if isinstance(default, tuple):
        default = ",".join(default)
    return f"`{default}`" if default not in ("", None) else "empty"


def main() -> None:
    """Replace the rows of the page."""
    lines = PAGE.read_text().splitlines()
    places = [number for number, line in enumerate(lines) if line.startswith(ROW)]
    lines[places[0] : places[-1] + 1] = rows()
    PAGE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
