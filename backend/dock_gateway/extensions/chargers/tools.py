"""The tool of agents for shared docks: they read who has each. What stands there, people say."""

from dock_gateway.access.carry_out import Fields
from dock_gateway.access.tool import Nothing, Tool
from dock_gateway.core.access import Principal
from dock_gateway.extensions.chargers import routes
from dock_gateway.extensions.chargers.board import DockBoard
from dock_gateway.extensions.chargers.schema import SharedDockList
from dock_gateway.http.operation import carries_out
from dock_gateway.http.parts import Parts


@carries_out(routes.list_shared_docks)
async def list_shared_docks(parts: Parts, principal: Principal, _: Fields) -> Fields:
    """List the shared docks by name."""
    return {"shared_docks": await parts[DockBoard].documents(principal.grant)}


TOOLS = (
    Tool(
        "list_shared_docks",
        "List shared docks",
        "List the docks that robots share: which robot has each or is on its way, why one is out of order, and which "
        "robots wait. A goal to a dock that another robot has is refused with dock_occupied.",
        list_shared_docks,
        Nothing,
        SharedDockList,
        reads=True,
    ),
)
