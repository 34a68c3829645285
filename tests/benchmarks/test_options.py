"""The command line of `make bench`."""

from pathlib import Path

import pytest
from benchmarks.options import read_options


def test_short_run_still_has_three_turns() -> None:
    options = read_options(["--short", "--cases", "bc"])
    assert (options.cases, options.rounds, options.seconds) == ("bc", 3, 2.0)


def test_variant_is_a_checkout_with_its_environment(tmp_path: Path) -> None:
    with pytest.raises(SystemExit):
        read_options(["--variant", f"before={tmp_path}"])
    gateway = tmp_path / ".venv/bin/dock-gateway"
    gateway.parent.mkdir(parents=True)
    gateway.touch()
    assert read_options(["--variant", f"before={tmp_path}"]).variants == (("before", tmp_path),)
