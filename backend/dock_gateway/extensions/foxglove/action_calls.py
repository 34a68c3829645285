"""Actions as services: send a goal, cancel one, get a result. A goal is one of the gateway, as at `/ws`."""

from typing import Any

from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound
from dock_gateway.core.grant import Role
from dock_gateway.core.request import wait_while_permitted
from dock_gateway.extensions.foxglove.protocol import Json
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import MAX_WAIT, read_goal_id
from dock_gateway.streams.rights import Rights


class ActionCalls:
    """Carries out the calls of one client.

    Args:
        parts: Carry them out.
        rights: Those of the client's user.
    """

    def __init__(self, parts: Parts, rights: Rights) -> None:
        self._parts = parts
        self._rights = rights
        self._newest: dict[str, str] = {}  # the goals that the client has sent last, by action

    async def send(self, action: str, goal: Any) -> Json:
        """Send a goal; return its id and status when the action server has accepted it.

        Raises:
            GatewayError: It may not be sent, or was not accepted.
        """
        sent = (await self._rights.command("send_goal", {"action": action, "goal": goal}))["goal"]
        self._newest[action] = sent["goal_id"]
        return {"goal_id": sent["goal_id"], "status": sent["status"]}

    async def cancel(self, action: str, request: Json) -> Json:
        """Ask the action server to cancel a goal.

        Raises:
            GatewayError: There is no such goal, it may not be canceled, or the server refuses.
        """
        goal_id = await self._goal_id(action, request)
        canceled = (await self._rights.command("cancel_goal", {"goal_id": goal_id}))["goal"]
        return {"goal_id": goal_id, "status": canceled["status"]}

    async def result(self, action: str, request: Json) -> Json:
        """Wait for the end of a goal, and return its result.

        Raises:
            Conflict: `goal_running`: it has not ended in time.
            GatewayError: There is no such goal, or it may not be seen.
        """
        return await self.get_result(await self._goal_id(action, request))

    @operation(Role.VIEWER, Scope.GOAL, Audit.NEVER)
    async def get_result(self, goal_id: str) -> Json:
        """Wait for the end of a goal, and return its result."""
        await self._rights.require(ActionCalls.get_result, {"goal_id": goal_id})
        goal = await self._parts[Goals].get(goal_id, self._rights.grant)
        if not goal.status.terminal:
            tracker = (await self._parts[ActionRegistry].find(goal.action_name)).tracker
            await wait_while_permitted(tracker.wait_terminal(goal, MAX_WAIT))
        if not goal.status.terminal:
            raise Conflict(f"the goal {goal_id} is still {goal.status.value}: ask again", code="goal_running")
        error = "" if goal.error is None else goal.error.detail
        return {"result": goal.result, "goal_id": goal_id, "status": goal.status.value, "error": error}

    async def _goal_id(self, action: str, request: Json) -> str:
        """Return the goal that a request is about: without an id, the client's newest one.

        Raises:
            InvalidField: The client has sent none, or the id is none.
            NotFound: The goal is on another action.
        """
        given = request.get("goal_id")
        if given is None:
            if action not in self._newest:
                expected = "the id of a goal; without one, it is the last goal of this connection"
                raise InvalidField([FieldError("goal_id", expected, f"it has sent none to {action}")])
            return self._newest[action]
        goal_id = read_goal_id(str(given))
        goal = await self._parts[Goals].get(goal_id, self._rights.grant)
        if goal.action_name != action:
            raise NotFound(f"the goal {goal_id} is on {goal.action_name}, not on {action}", code="goal_not_found")
        return goal_id
