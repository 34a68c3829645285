"""Every error code is in one list, with the status with which it is raised, and on the page of errors."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from scripts import error_table

from dock_gateway.app import create_app
from dock_gateway.core import errors
from dock_gateway.core.dock_adapters import nav2
from dock_gateway.core.error_codes import CORE, NAMES, OF_SERVER, SHARED, code_of_server
from dock_gateway.extension import Installed
from dock_gateway.extension_list import OURS
from dock_gateway.http import problems
from dock_gateway.settings import Settings
from dock_hub import app as hub_app
from dock_hub import error_codes as of_hub
from dock_hub.settings import HubSettings

ROOT = Path(__file__).parents[2]
EXTENSIONS = ROOT / "backend/dock_gateway/extensions"
HUB = ROOT / "backend/dock_hub"
CLASSES = {
    name: int(kind.status)
    for name, kind in vars(errors).items()
    if isinstance(kind, type) and issubclass(kind, errors.GatewayError)
}
# Not answers to a client: what a hub and its sites tell each other (docs/extensions/sites.md).
BETWEEN_SITES = {"Refusal"}
# What raises `NOUN_not_found`, and which of its arguments is the noun.
NOUN_AT = {"SharedBook": 1, "not_found": 0}
STATUSES = {code.name: code.status for code in error_table.all_codes()}


@cache
def modules() -> list[tuple[Path, ast.Module]]:
    paths = [path for package in ("dock_gateway", "dock_hub") for path in (ROOT / "backend" / package).rglob("*.py")]
    return [(path, ast.parse(path.read_text())) for path in paths if path.name != "error_codes.py"]


def raised() -> Iterator[tuple[str, str, str, int | None]]:
    """Yield where, by which class, with which code and, if it is plain, with which status an error is made."""
    for path, tree in modules():
        for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
            made = call.func.id if isinstance(call.func, ast.Name) else ""
            given = {each.arg: each.value for each in call.keywords}
            code = given.get("code")
            if made in BETWEEN_SITES or not isinstance(code, ast.Constant) or not isinstance(code.value, str):
                continue
            plain = made in CLASSES and "status" not in given
            yield f"{path}:{call.lineno}", made, code.value, CLASSES[made] if plain else None


def literals(folder: Path) -> set[str]:
    trees = [tree for path, tree in modules() if path.is_relative_to(folder)]
    return {
        node.value
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def named(folder: Path) -> set[str]:
    """Return the codes that are made of a noun, where the noun is given."""
    calls = (
        node
        for path, tree in modules()
        if path.is_relative_to(folder)
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in NOUN_AT
    )
    nouns = (call.args[NOUN_AT[call.func.id]] for call in calls if isinstance(call.func, ast.Name))
    return {f"{noun.value}_not_found" for noun in nouns if isinstance(noun, ast.Constant)}


def test_every_code_that_is_raised_is_in_the_list_with_its_status() -> None:
    found = [*raised()]
    assert len(found) > 150
    assert [each for each in found if each[2] not in STATUSES] == []
    # A warning of an answer is a problem document, too, without being one of an answer.
    wrong = [each for each in found if each[3] is not None and STATUSES[each[2]] not in (None, each[3])]
    assert wrong == []


def test_the_default_code_of_a_class_is_in_the_list_with_its_status() -> None:
    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, errors.GatewayError)]
    assert {kind.code: STATUSES[kind.code] for kind in kinds} == {kind.code: int(kind.status) for kind in kinds}
    assert {*problems.CODES.values()} <= STATUSES.keys()


@pytest.mark.parametrize("name", ["", *OURS, "dock_hub"])
def test_every_code_of_a_list_is_used(name: str) -> None:
    """An extension's by the extension: it is taken out with it."""
    folder, codes = ROOT / "backend", CORE
    if name == "dock_hub":
        folder, codes = HUB, of_hub.CODES
    elif name:
        folder, codes = EXTENSIONS / name, tuple(Installed.load([name]).errors)
    found = literals(folder) | named(folder)
    assert [code.name for code in codes if code.name not in found] == []


def test_no_code_is_in_two_lists() -> None:
    names = [code.name for code in error_table.all_codes()]
    assert len(names) == len(set(names))


def test_the_page_has_them_all() -> None:
    lines = error_table.PAGE.read_text().splitlines()
    first = lines.index(error_table.HEAD) + 2
    assert lines[first : first + len(STATUSES)] == error_table.rows(), "run `make format`"


def test_the_documents_have_them() -> None:
    gateway = create_app(Settings()).openapi()["components"]["schemas"]["Problem"]["x-codes"]
    hub = hub_app.create_hub_app(HubSettings(nats="nats://127.0.0.1")).openapi()["components"]["schemas"]["Problem"][
        "x-codes"
    ]
    assert {code["code"]: code["status"] for code in gateway} == {
        name: status for name, status in STATUSES.items() if name not in {code.name for code in of_hub.CODES}
    }
    assert {"site_not_found", "goal_not_found"} <= {code["code"] for code in hub}
    assert ("webhook_not_found" in {code["code"] for code in hub}) == ("webhooks" in OURS)
    assert all(code["description"].endswith((".", ":")) for code in gateway)


def test_only_what_may_succeed_later_is_429_or_503() -> None:
    assert all(code.status == 429 for code in error_table.all_codes() if code.name.startswith("too_m"))
    assert STATUSES["limit_reached"] == 409


@pytest.mark.parametrize(
    ("said", "code"),
    [("FAILED_TO_CHARGE", "failed_to_charge"), ("STOPPED", "server_stopped"), ("DOCK_BUSY", "dock_busy")],
)
def test_a_servers_code_is_none_of_ours(said: str, code: str) -> None:
    assert code_of_server(said) == code


def test_codes_of_nav2_are_none_of_ours() -> None:
    codes = {code for known in (nav2.DOCK_ERRORS, nav2.UNDOCK_ERRORS) for code, _ in known.values()}
    assert codes & NAMES <= SHARED <= NAMES
    assert not [name for name in NAMES if name.startswith(OF_SERVER)]
