"""What a hub is made of is imported where ROS is not installed."""

import subprocess
import sys
import tomllib
from pathlib import Path

from dock_gateway.extension_list import OURS, PACKAGE, modules_of
from dock_hub.settings import EXTENSIONS

ROOT = Path(__file__).parents[2]
CONTRACT = "a hub, what it imports of the gateway, and the schemas of extensions need no ROS"
# A name that is None is not found.
PROGRAM = """
import sys
from importlib import import_module
from pkgutil import walk_packages

modules, missing = (each.split() for each in sys.argv[1:])
sys.modules.update(dict.fromkeys(missing))
for name in modules:
    module = import_module(name)
    for found in walk_packages(getattr(module, "__path__", []), f"{name}."):
        import_module(found.name)
assert not [name for name in sys.modules if name.startswith("dock_gateway.ros.")]
"""


def test_a_hub_needs_no_ros() -> None:
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    contract = next(each for each in linter["contracts"] if each["name"] == CONTRACT)
    modules, missing = (contract[key] for key in ("source_modules", "forbidden_modules"))
    modules = [name for name in modules if "*" not in name] + [*modules_of("schema")]
    modules = [*modules, *(f"{PACKAGE}.{name}" for name in OURS if name in EXTENSIONS)]
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, " ".join(modules), " ".join(missing)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
