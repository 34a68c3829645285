"""What the benchmark takes from the tests needs nothing that the benchmark's own environment lacks."""

import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

ROOT = Path(__file__).parents[2]
# What these import if it is installed, and do without.
IF_THERE = {"backports.zstd"}
LOAD = """import sys; before = set(sys.modules)
import tests.support.domain, tests.support.processes
print(*(set(sys.modules) - before))"""


def with_dependencies(names: list[str]) -> set[str]:
    """These distributions and what they require, without extras."""
    found: set[str] = set()
    while names:
        name = names.pop().lower()
        if name not in found:
            found.add(name)
            try:
                needed = [each for each in requires(name) or () if "extra ==" not in each]
            except PackageNotFoundError:  # only the benchmark has it
                continue
            names += [re.split(r"[^A-Za-z0-9_.-]", each)[0] for each in needed]
    return found


def test_the_environment_of_the_benchmark_has_what_it_imports() -> None:
    lines = (ROOT / "benchmarks/requirements.txt").read_text().splitlines()
    present = with_dependencies([line.partition("==")[0] for line in lines if not line.startswith("#")])
    run = subprocess.run([sys.executable, "-c", LOAD], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = {name.partition(".")[0] for name in run.stdout.split()} - {"tests", *sys.stdlib_module_names}
    distributions = packages_distributions()
    needed = {distributions[name][0].lower() for name in loaded if name in distributions}
    assert "httpx2" in needed
    assert needed - IF_THERE <= present
