"""The contract: all that docs/compatibility.md promises, in the form of an OpenAPI document, and as it was frozen.

    python -m tests.support.contract            # say what has changed
    python -m tests.support.contract --freeze   # add what is new to the frozen files

Besides requests and answers it has the settings (`SET settings`), the commands (`RUN dock-gateway dock`) and the tools
of agents (`CALL dock_robot`) as operations, so that one set of rules compares all; and names: messages of streams,
error codes and metrics. Of each extension, a file in the folder of its tests has what it adds.
"""

import re
import sys
from collections.abc import Iterable, Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import click
import orjson
from pydantic import BaseModel

from dock_gateway.app import create_app
from dock_gateway.cli import COMMANDS, GROUP, main
from dock_gateway.cli.options import SettingOption, is_tuning
from dock_gateway.core.error_codes import CORE, ErrorCode
from dock_gateway.extension import Installed
from dock_gateway.extension_list import OURS, ours_with_settings, with_extensions
from dock_gateway.settings import Settings
from dock_gateway.streams.asyncapi import asyncapi_document
from dock_hub.app import create_hub_app
from dock_hub.error_codes import CODES
from dock_hub.schema import GOAL_FIELDS
from dock_hub.settings import HubSettings
from tests.support.compatibility import ALONE, METHODS, Changes, compare, for_programs

ROOT = Path(__file__).parents[2]
GATEWAY = ROOT / "tests/dock_gateway/contract.json"
HUB = ROOT / "tests/dock_hub/contract.json"
OF_EXTENSIONS = ROOT / "tests/extensions"
METRICS = re.compile(r"^\| `(dock_gateway_\w+)` \| (\w+) \|", re.MULTILINE)
REFERENCE = "#/components/schemas/"
Document = dict[str, Any]


# ---------------------------------------------------------------------- what there is now


def of_gateway(names: Iterable[str] = OURS) -> Document:
    """Return the contract of a gateway that has some extensions."""
    names = tuple(names)
    installed = Installed.load(names)
    openapi = create_app(Settings(), installed=installed).openapi()
    found = _promised(openapi)
    _add_settings(found, with_extensions("Settings", Settings, ours_with_settings(names)))
    _add_commands(found, _commands(names))
    if "agents" in names:
        _add_tools(found)
    found["names"] |= _codes([*CORE, *installed.errors]) | _messages(asyncapi_document(openapi, installed.events))
    found["names"] |= _metrics(names)
    return found


def of_hub() -> Document:
    """Return the contract of a hub, without what its extensions have at a gateway, too."""
    found = _promised(create_hub_app(HubSettings()).openapi())
    for path in [path for path in found["paths"] if path in _paths_of_extensions()]:
        del found["paths"][path]
    for goal in (found["components"]["schemas"][name] for name in ("Goal", "ExportedGoal")):
        goal["properties"] = {name: each for name, each in goal["properties"].items() if name not in GOAL_FIELDS}
        goal["required"] = [name for name in goal["required"] if name not in GOAL_FIELDS]
    _add_settings(found, HubSettings)
    _add_commands(found, {entry.name: entry.load() for entry in entry_points(group=GROUP)})
    page = (ROOT / "docs/extensions/sites.md").read_text()
    found["names"] |= _codes(CODES) | {f"metric {metric}": kind for metric, kind in METRICS.findall(page)}
    return _reachable(found)


def _paths_of_extensions() -> set[str]:
    return {path for name in OURS for path in read(file_of(name)).get("paths", {})}


def _promised(openapi: Document) -> Document:
    """Return what programs can rely on: no prose, no unstable operations, no bodies of errors."""
    paths: Document = {}
    for path, item in for_programs(openapi)["paths"].items():
        for method, operation in item.items():
            if method in METHODS and "x-stability" not in operation:
                answers = {status: each for status, each in operation["responses"].items() if status < "4"}
                kept = ("operationId", "parameters", "requestBody", "deprecated", "x-robot")
                paths.setdefault(path, {})[method] = {
                    **{name: operation[name] for name in kept if name in operation},
                    "responses": answers,
                }
    schemas = for_programs(openapi["components"])["schemas"]
    return _reachable({"paths": paths, "components": {"schemas": schemas}, "names": {}})


def _reachable(document: Document) -> Document:
    """Return a document without the schemas that nothing leads to."""
    schemas, wanted = document["components"]["schemas"], set[str]()

    def follow(part: object) -> None:
        if isinstance(part, dict):
            name = str(part.get("$ref", "")).removeprefix(REFERENCE)
            if name in schemas and name not in wanted:
                wanted.add(name)
                follow(schemas[name])
            for value in part.values():
                follow(value)
        elif isinstance(part, list):
            for value in part:
                follow(value)

    follow(document["paths"])
    for name in ALONE:
        follow({"$ref": f"{REFERENCE}{name}"})
    return {**document, "components": {"schemas": {name: schemas[name] for name in sorted(wanted)}}}


def _add_settings(document: Document, kind: type[Settings]) -> None:
    """Add the settings, without those that are for tests and experts, and without defaults, which may be paths."""
    schema = _added(document, kind, "settings.")
    schema["properties"] = {
        name: {key: value for key, value in each.items() if key != "default"}
        for name, each in schema["properties"].items()
        if not is_tuning(kind.model_fields[name])
    }
    document["paths"]["settings"] = {"set": {"requestBody": _content(schema), "responses": {}}}


def _added(document: Document, model: type[BaseModel], prefix: str, mode: Any = "validation") -> Document:
    """Return the schema of a model, and add those that it needs to a document."""
    schema = model.model_json_schema(ref_template=f"{REFERENCE}{prefix}{{model}}", mode=mode)
    needed = schema.pop("$defs", {})
    document["components"]["schemas"] |= {f"{prefix}{name}": for_programs(each) for name, each in needed.items()}
    found: Document = for_programs(schema)
    return found


def _content(schema: Document) -> Document:
    return {"content": {"application/json": {"schema": schema}}}


def _commands(names: Iterable[str]) -> dict[str, click.Command]:
    """Return the commands of the gateway, and those of extensions."""
    context = click.Context(main)
    further = {entry.name for entry in entry_points(group=GROUP)}
    found = {}
    for name in main.list_commands(context):
        command = main.get_command(context, name)
        module = getattr(getattr(command, "callback", None), "__module__", "")
        extension = next((each for each in OURS if f".extensions.{each}." in module), None)
        if command is not None and name not in further and (name in COMMANDS or extension in names):
            found[name] = command
    return found


def _add_commands(document: Document, commands: dict[str, click.Command]) -> None:
    for name, command in _with_subcommands(commands, "dock-gateway"):
        parameters = [each for parameter in command.params for each in _options(parameter)]
        described = {"parameters": parameters, "responses": {}}
        document["paths"][name] = {"run": described | ({"deprecated": True} if command.deprecated else {})}


def _with_subcommands(commands: dict[str, click.Command], path: str) -> Iterator[tuple[str, click.Command]]:
    for name, command in sorted(commands.items()):
        if command.hidden:
            continue
        yield f"{path} {name}", command
        if isinstance(command, click.Group):
            yield from _with_subcommands(dict(command.commands), f"{path} {name}")


def _options(parameter: click.Parameter) -> Iterator[Document]:
    """Yield the spellings of an option, or an argument. The settings are described as such."""
    if isinstance(parameter, SettingOption) or getattr(parameter, "hidden", False):
        return
    flag = getattr(parameter, "is_flag", False)
    schema: Document = {"type": "flag" if flag else parameter.type.name}
    if isinstance(parameter.type, click.Choice):
        schema = {"type": "string", "enum": [str(each) for each in parameter.type.choices]}
    if parameter.multiple or parameter.nargs != 1:
        schema = {"type": "array", "items": schema}
    if isinstance(parameter, click.Argument):
        yield {"in": "argument", "name": str(parameter.name), "required": parameter.required, "schema": schema}
        return
    for option in (*parameter.opts, *parameter.secondary_opts):
        yield {"in": "option", "name": option, "required": parameter.required, "schema": schema}


def _add_tools(document: Document) -> None:
    from dock_gateway.extensions.agents.tools import TOOLS

    for name, tool in TOOLS.items():
        returned = _content(_added(document, tool.returns, "tools.answers.", "serialization"))
        document["paths"][name] = {
            "call": {
                "requestBody": _content(_added(document, tool.takes, "tools.")),
                "responses": {"200": returned},
            }
        }


def _codes(codes: Iterable[ErrorCode]) -> dict[str, str]:
    found: dict[str, set[int]] = {}
    for code in codes:
        found.setdefault(f"error {code.name}", set()).add(code.status or 0)
    return {name: " ".join(map(str, sorted(statuses))) for name, statuses in found.items()}


def _messages(asyncapi: Document) -> dict[str, str]:
    """Return the messages of each stream."""
    return {
        f"{channel['address']} {message}": asyncapi["components"]["messages"][message]["name"]
        for channel in asyncapi["channels"].values()
        for message in channel["messages"]
    }


def _metrics(names: Iterable[str]) -> dict[str, str]:
    """Return the metrics with their types, by the page, which a test compares with a gateway."""
    core = _source(ROOT / "backend/dock_gateway/observability")
    sources = {name: _source(ROOT / "backend/dock_gateway/extensions" / name) for name in OURS}
    found = {}
    for metric, kind in METRICS.findall((ROOT / "docs/metrics.md").read_text()):
        bare = metric.removeprefix("dock_gateway_").removesuffix("_total")
        owners = [name for name, source in sources.items() if f'"{bare}"' in source and f'"{bare}"' not in core]
        if not owners or set(owners) & set(names):
            found[f"metric {metric}"] = kind
    return found


def _source(folder: Path) -> str:
    return "\n".join(path.read_text() for path in folder.rglob("*.py"))


# ---------------------------------------------------------------------- what was frozen


def file_of(name: str) -> Path:
    """Return the file with what an extension adds."""
    return OF_EXTENSIONS / name / "contract.json"


def read(path: Path) -> Document:
    """Return a frozen document; an empty one if there is none."""
    found: Document = orjson.loads(path.read_bytes()) if path.exists() else {}
    return found


def frozen_gateway() -> Document:
    """Return the frozen contract of the gateway with the extensions that there are."""
    found: Any = read(GATEWAY)
    for name in OURS:
        found = merged(found, read(file_of(name)))
    return found  # type: ignore[no-any-return]


def merged(base: Any, added: Any) -> Any:
    """Return a document with what another one adds."""
    if isinstance(base, dict) and isinstance(added, dict):
        return {
            key: merged(base[key], added[key]) if key in base and key in added else added.get(key, base.get(key))
            for key in sorted(base.keys() | added.keys())
        }
    if isinstance(base, list) and isinstance(added, list):
        return [*base, *(each for each in added if each not in base)]
    return added


def added_to(base: Any, whole: Any) -> Any:
    """Return what a document adds to another one, for `merged`."""
    if isinstance(base, dict) and isinstance(whole, dict):
        return {
            key: added_to(base[key], value) if key in base else value
            for key, value in whole.items()
            if key not in base or base[key] != value
        }
    if isinstance(base, list) and isinstance(whole, list):
        return [each for each in whole if each not in base]
    return whole


def freeze() -> list[Path]:
    """Write the files; return those that have changed."""
    core = of_gateway(())
    documents = {GATEWAY: core} | {file_of(name): added_to(core, of_gateway((name,))) for name in OURS}
    changed = [path for path, document in documents.items() if _write(path, document)]
    return [*changed, *([HUB] if _write(HUB, of_hub()) else [])]


def _write(path: Path, document: Document) -> bool:
    if not document:
        path.unlink(missing_ok=True)
        return False
    text = orjson.dumps(document, option=orjson.OPT_INDENT_2 | orjson.OPT_SORT_KEYS | orjson.OPT_APPEND_NEWLINE)
    if path.exists() and path.read_bytes() == text:
        return False
    path.write_bytes(text)
    return True


def changes() -> dict[str, Changes]:
    """Return what has changed since it was frozen, of a gateway and of a hub."""
    return {"gateway": compare(frozen_gateway(), of_gateway()), "hub": compare(read(HUB), of_hub())}


@click.command()
@click.option("--freeze", "freezes", is_flag=True, help="Add what is new, and what is deprecated now.")
@click.option("--break", "breaks", is_flag=True, help="With --freeze: also what is broken, before the first release.")
def run(*, freezes: bool, breaks: bool) -> None:
    """Say what has changed in the contract since it was frozen, and freeze it."""
    first = not GATEWAY.exists()
    found = {} if first else changes()
    for whose, each in found.items():
        click.echo("".join(f"{whose}: {line}\n" for line in each.lines()), nl=False)
    if not freezes:
        return
    if any(each.broken for each in found.values()) and not breaks:
        sys.exit("something is broken: see docs/compatibility.md")
    for path in freeze():
        click.echo(path.relative_to(ROOT))


if __name__ == "__main__":
    run()
