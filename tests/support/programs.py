"""The programs of the project, imported with all that they import when they start, or once they run."""

from contextlib import suppress
from importlib import import_module
from importlib.metadata import entry_points

from dock_gateway.extension_list import modules_of
from docking.programs import MODULES

PROGRAMS = {
    entry.name: entry.load()
    for entry in entry_points(group="console_scripts")
    if entry.module.partition(".")[0] in {"dock_gateway", "docking"}
}
for module in MODULES.values():
    import_module(module)
import_module("dock_gateway.cli.gateway")  # which `dock-gateway serve` imports when it runs
for module in modules_of("extension"):  # which every gateway imports
    with suppress(Exception):  # as a gateway does, which says what is missing
        import_module(module)
# What libraries import when a gateway opens its database, listens and checks a password, a node is made, and a
# simulation begins. What is missing is imported then, or not at all.
for module in (
    "numpy.random",
    "rosidl_generator_py",
    "service_msgs.msg",
    "sqlalchemy.dialects.sqlite.aiosqlite",
    "type_description_interfaces.msg",
    "uvicorn.lifespan.on",
    "uvloop",
):
    with suppress(ImportError):
        import_module(module)
