"""Writes the tables of settings in docs/configuration.md, from the settings and their descriptions: `make format`."""

from itertools import starmap
from pathlib import Path

from pydantic.fields import FieldInfo

from dock_gateway.cli.options import TYPE, describe_default, groups_of, is_tuning, option_name
from dock_gateway.setting_groups.group import PREFIX
from dock_gateway.settings import WITHOUT_OPTION

PAGE = Path(__file__).parents[1] / "docs/configuration.md"
BEGIN, END = "<!-- The tables are written by `make format`. -->", "<!-- The end of the tables. -->"
TUNING = """\
### Tuning

Tests and experts change these. **They are not promised**: they may change or go with any version, and `--help` does
not show them."""


def tables() -> str:
    """Return the tables: one for each group, and one of the settings that no person needs."""
    groups = {
        f"### {heading}": [field for field in fields if not is_tuning(field[1])]
        for heading, fields in groups_of(TYPE).items()
    }
    groups[TUNING] = [field for fields in groups_of(TYPE).values() for field in fields if is_tuning(field[1])]
    return "\n\n".join(f"{text}\n\n{_table(fields)}" for text, fields in groups.items())


def _table(fields: list[tuple[str, FieldInfo]]) -> str:
    return "\n".join(("| variable | option | default | meaning |", "|---|---|---|---|", *starmap(_row, fields)))


def _row(name: str, field: FieldInfo) -> str:
    option = "\N{EN DASH}" if name in WITHOUT_OPTION else f"`{option_name(name)}`"
    default = describe_default(field.default)
    return f"| `{PREFIX}{name.upper()}` | {option} | {f'`{default}`' if default else 'empty'} | {field.description} |"


def written() -> str:
    """Return the tables that the page has."""
    return PAGE.read_text().partition(BEGIN)[2].partition(END)[0].strip()


def main() -> None:
    """Replace the tables of the page."""
    before, _, rest = PAGE.read_text().partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}\n\n{tables()}\n\n{END}{after}")


if __name__ == "__main__":
    main()
