"""Writes the table of error codes in docs/errors.md, from the lists of the gateway, its extensions and the hub."""

from pathlib import Path

from dock_gateway.core.error_codes import CORE, ErrorCode
from dock_gateway.extension import Installed
from dock_gateway.extension_list import OURS
from dock_hub import error_codes as of_hub

PAGE = Path(__file__).parents[1] / "docs/errors.md"
HEAD = "| status | code | when |"
NO_STATUS = "\N{EN DASH}"


def all_codes() -> list[ErrorCode]:
    """Return the codes in the order of the page: by status, then by name; those without a status last."""
    codes = [*CORE, *Installed.load(OURS).errors, *of_hub.CODES]
    return sorted(codes, key=lambda code: (code.status or 1000, code.name))


def rows() -> list[str]:
    """Return the rows of the table."""
    return [_row(code) for code in all_codes()]


def _row(code: ErrorCode) -> str:
    more = f" ([{code.page.partition('#')[0]}]({code.page}))" if code.page else ""
    return f"| {code.status or NO_STATUS} | `{code.name}` | {code.meaning}{more} |"


def main() -> None:
    """Replace the rows of the page."""
    lines = PAGE.read_text().splitlines()
    first = lines.index(HEAD) + 2
    end = first + lines[first:].index("")
    lines[first:end] = rows()
    PAGE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
