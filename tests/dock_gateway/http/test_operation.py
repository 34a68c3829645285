"""Each route and each command says what it needs, and it is what is agreed."""

from pathlib import Path

import pytest
from fastapi import APIRouter

from dock_gateway import app as app_module
from dock_gateway.app import api_routers, create_app
from dock_gateway.core.grant import Role
from dock_gateway.extension import Extension, extensions
from dock_gateway.http.operation import Audit, Operation, Scope, Unaudited, Undeclared, operation, operation_of
from dock_gateway.settings import Settings
from dock_gateway.streams.commands import COMMANDS
from dock_gateway.streams.socket import OPERATIONS

# Who may do what, in one page and one of each extension: a change of a role, a scope or the audit log changes it.
AGREED = Path(__file__).with_name("operations.txt")
OF_EXTENSIONS = Path(__file__).parents[2] / "extensions"


async def change() -> None:
    """An endpoint."""


def described(name: str, needed: Operation) -> str:
    role = "public" if needed.role is None else needed.role.value
    extras = "".join(f" {flag}" for flag in ("sends_goal", "reads_body", "any_query") if getattr(needed, flag))
    return f"{name:<50} {role:<10} {needed.scope.name:<8} {needed.audit.name}{extras}"


def test_every_operation_needs_what_is_agreed() -> None:
    found = [
        described(
            f"{' '.join(getattr(route, 'methods', ())) or 'WebSocket'} {route.path}", operation_of(route.endpoint)
        )
        for router in api_routers(Settings(), extensions())
        for route in router.routes
    ]
    found += [described(f"/ws {name}", needed) for name, needed in OPERATIONS.items()]
    pages = [AGREED, *OF_EXTENSIONS.glob("*/operations.txt")]
    assert sorted(found) == sorted(line for page in pages for line in page.read_text().splitlines())


@pytest.mark.parametrize("extension", [*extensions()], ids=lambda extension: extension.name)
def test_the_operations_of_an_extension_are_in_its_folder(extension: Extension) -> None:
    paths = [route.path for router in extension.routes(Settings()) for route in router.routes]  # type: ignore[attr-defined]
    page = OF_EXTENSIONS / extension.name / "operations.txt"
    assert (
        sorted(paths) == sorted(line.split()[1] for line in page.read_text().splitlines())
        if paths
        else not page.exists()
    )


def test_every_command_is_declared() -> None:
    assert OPERATIONS.keys() == COMMANDS.keys() | {"subscribe", "unsubscribe"}


def test_a_route_that_does_not_say_what_it_needs_keeps_the_app_from_being_made(monkeypatch: pytest.MonkeyPatch) -> None:
    router = APIRouter()
    router.post("/change")(change)
    monkeypatch.setattr(app_module, "api_routers", lambda *_: (router,))
    with pytest.raises(Undeclared, match=r"test_operation\.change does not say which role it needs: put @operation"):
        create_app(Settings())


def test_nothing_that_changes_something_is_kept_out_of_the_audit_log(monkeypatch: pytest.MonkeyPatch) -> None:
    @operation(Role.ADMIN, Scope.EVERY, Audit.NEVER)
    async def secretly() -> None:
        """An endpoint."""

    router = APIRouter()
    router.post("/change")(secretly)
    monkeypatch.setattr(app_module, "api_routers", lambda *_: (router,))
    with pytest.raises(Unaudited, match="/change may change something: the audit log must have it"):
        create_app(Settings())


@pytest.mark.parametrize(
    ("audit", "methods"),
    [
        (Audit.NEVER, set()),
        (Audit.CHANGES, {"POST", "DELETE"}),
        (Audit.ALWAYS, {"GET", "HEAD", "POST", "DELETE"}),
        (Audit.STORED_FIRST, {"GET", "HEAD", "POST", "DELETE"}),
    ],
)
def test_what_the_audit_log_has(audit: Audit, methods: set[str]) -> None:
    needed = Operation(Role.VIEWER, Scope.ANY, audit)
    assert {method for method in ("GET", "HEAD", "POST", "DELETE") if needed.audits(method)} == methods
