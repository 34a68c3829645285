"""The programs of the project, imported with all that they import when they start."""

from importlib import import_module
from importlib.metadata import entry_points

from docking.programs import MODULES

PROGRAMS = {
    entry.name: entry.load()
    for entry in entry_points(group="console_scripts")
    if entry.module.partition(".")[0] in {"dock_gateway", "docking"}
}
for module in MODULES.values():
    import_module(module)
import_module("dock_gateway.cli.gateway")  # which `dock-gateway serve` imports when it runs
