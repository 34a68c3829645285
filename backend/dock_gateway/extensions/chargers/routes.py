"""`/shared-docks`: docks that at most one robot has at a time."""

import re
from typing import Annotated

from fastapi import APIRouter, Depends, Path
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.grant import Role
from dock_gateway.extensions.chargers.board import DockBoard
from dock_gateway.extensions.chargers.dock import DockBody
from dock_gateway.extensions.chargers.schema import DockReport, SharedDock, SharedDockList
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Shared docks"], prefix="/shared-docks")

# A name by which docking servers know a dock.
DOCK_ID = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}")


async def _dock_id_in_path(
    dock_id: Annotated[
        str,
        Path(
            description="The name by which the docking servers know it",
            json_schema_extra={"pattern": f"^{DOCK_ID.pattern}$"},
        ),
    ],
) -> str:
    if not DOCK_ID.fullmatch(dock_id):
        what = "up to 60 letters, digits and `_`, and `.` and `-` after the first"
        raise InvalidField([FieldError("dock_id", what, got(dock_id), "path")])
    return dock_id


DockId = Annotated[str, Depends(_dock_id_in_path)]


@router.get("", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED)
async def list_shared_docks(board: Part[DockBoard], grant: TheGrant) -> Answer[SharedDockList]:
    """List the shared docks by name, each with who has it and who waits for it."""
    return json_response({"shared_docks": await board.documents(grant)})


@router.get("/{dock_id}", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def get_shared_dock(dock_id: DockId, board: Part[DockBoard], grant: TheGrant) -> Item[SharedDock]:
    """Return a shared dock."""
    return item_response(await board.document(dock_id, grant))


@router.put("/{dock_id}", openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def replace_shared_dock(
    dock_id: DockId, body: SignedBody[DockBody], board: Part[DockBoard], condition: WriteCondition
) -> Item[SharedDock]:
    """Store a shared dock, new or changed, at every gateway that shares the history.

    From then on at most one robot has it: a docking goal reserves it, and is refused (`dock_occupied`) while another
    robot has it.
    """
    dock, new = await board.replace(dock_id, body.entry(), condition)
    return item_response(dock, f"{router.prefix}/{dock_id}" if new else None)


@router.delete("/{dock_id}", status_code=204, openapi_extra=UNSTABLE)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def remove_shared_dock(dock_id: DockId, board: Part[DockBoard], condition: ChangeCondition) -> Response:
    """Remove a shared dock: nothing is reserved there any more. Goals to it go on."""
    return await removed(board.remove(dock_id, condition))


@router.post("/{dock_id}/report", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.LISTED, errors=(404, 409))
async def report_shared_dock(
    dock_id: DockId, body: SignedBody[DockReport], board: Part[DockBoard], grant: TheGrant
) -> Answer[SharedDock]:
    """Say what you see at a shared dock: who stands there, and whether it is out of order."""
    return json_response(await board.report(dock_id, body, grant))
