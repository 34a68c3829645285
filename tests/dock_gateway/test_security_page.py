"""Every threat in docs/security.md names tests that exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/security.md").read_text()
TAKEN_OUT = tuple(
    f"extensions/{page}/"
    for page in set(re.findall(r"`extensions/(\w+)/", PAGE))
    if not (ROOT / "tests/extensions" / page).exists()
)
NAMED = sorted(
    named for named in set(re.findall(r"`([a-z_/]+\.py)::(test_\w+)`", PAGE)) if not named[0].startswith(TAKEN_OUT)
)
ROWS = [line for line in PAGE.splitlines() if re.match(r"\| [STRIDE](, [STRIDE])* \|", line)]


@pytest.mark.parametrize(("path", "name"), NAMED)
def test_what_it_names_exists(path: str, name: str) -> None:
    assert f"def {name}(" in (ROOT / "tests" / path).read_text()


def test_each_threat_names_a_test() -> None:
    assert len(ROWS) > 20
    assert [row for row in ROWS if "::test_" not in row] == []
