"""Approvals: an agent's goal to a real robot waits until a person allows it. In memory: a restart drops what waits."""

import asyncio
import uuid
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.dock_adapters.catalog import DockingCatalog
from dock_gateway.core.errors import Conflict, GatewayError, NotAllowed, NotFound, Unavailable
from dock_gateway.core.event import fleet_event, utc_now
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import is_under, parent_of
from dock_gateway.core.goal import Json, Verb, fragment
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.core.narrowing import narrow_approvals
from dock_gateway.core.request import slot, wait_while_permitted
from dock_gateway.settings import Settings


@dataclass(eq=False)
class Approval:
    """A goal that waits for a person. It is for this goal, once.

    Attributes:
        principal: The agent.
        robot: The namespace of the robot, by the name of the action.
        verb: Whether it docks or undocks the robot.
        goal: The goal message.
        refused: None if it was allowed, else why not.
    """

    principal: Principal
    action_name: str
    robot: str
    verb: Verb | None
    goal: Json
    requested_at: datetime
    expires_at: datetime
    id: str = field(default_factory=lambda: str(uuid.uuid4()))
    refused: asyncio.Future[GatewayError | None] = field(default_factory=asyncio.Future)

    @property
    def agent(self) -> str:
        """The name of the agent."""
        return _name_of(self.principal)

    def answer(self, refused: GatewayError | None) -> None:
        """Answer it, unless it is answered."""
        if not self.refused.done():
            self.refused.set_result(refused)

    def document(self) -> dict[str, Any]:
        """Return it as `GET /approvals` shows it, ready for `orjson`."""
        return {
            "id": self.id,
            "agent": self.agent,
            "client": self.principal.client,
            "robot": self.robot,
            "action_name": self.action_name,
            "verb": self.verb,
            "goal": fragment(self.goal),
            "requested_at": self.requested_at,
            "expires_at": self.expires_at,
        }


class Approvals:
    """The goals that wait for a person.

    Args:
        settings: How long they wait.
        fanout: Receives events.
        verb_of: Returns whether an action docks or undocks a robot.
        simulated: Returns whether a robot is simulated: goals to it need no approval.
    """

    def __init__(
        self,
        settings: Settings,
        fanout: Fanout,
        verb_of: Callable[[str], Verb | None],
        simulated: Callable[[str], bool],
    ) -> None:
        self._settings = settings
        self._catalog = DockingCatalog(settings)
        self._fanout = fanout
        self._verb_of = verb_of
        self._simulated = simulated
        self._waiting: dict[str, Approval] = {}
        self._asked = asyncio.Event()

    async def require(self, principal: Principal, action_name: str, goal: Json) -> None:
        """Wait until a person has allowed a goal of an agent; not at all if others send it, or the robot is simulated.

        Raises:
            NotAllowed: A person has refused it (`approval_refused`), or it has expired (`approval_expired`).
            Conflict: A stop was requested in the meantime (`stopped`).
            NotAuthenticated: The agent's login has ended (`invalid_token`).
            TooManyRequests: Too many goals wait already (`too_many_approvals`).
            Unavailable: The gateway closes.
        """
        if not self.needs(principal.grant, action_name):
            return
        robot = self._robot_of(action_name)
        with slot("approvals"):
            approval = self._ask(principal, action_name, robot, goal)
            try:
                await wait_while_permitted(self._wait(approval))
            finally:
                del self._waiting[approval.id]
                self._publish()
        if not approval.refused.done():
            within = f"{self._settings.approval_timeout:g} s"
            raise NotAllowed(
                f"no operator has allowed the goal on the dashboard within {within}", code="approval_expired"
            )
        if (refused := approval.refused.result()) is not None:
            raise refused

    def needs(self, grant: Grant, action_name: str) -> bool:
        """Return whether a goal needs a person: an agent sends it, and not to a simulated robot."""
        return grant.role is Role.AGENT and not self._is_simulated(action_name, self._robot_of(action_name))

    def _ask(self, principal: Principal, action_name: str, robot: str, goal: Json) -> Approval:
        now = utc_now()
        expires = now + timedelta(seconds=self._settings.approval_timeout)
        verb = self._verb_of(action_name)
        approval = Approval(principal, action_name, robot, verb, goal, now, expires)
        self._waiting[approval.id] = approval
        self._publish()
        self._asked.set()
        self._asked.clear()
        return approval

    async def _wait(self, approval: Approval) -> None:
        with suppress(TimeoutError):
            async with asyncio.timeout(self._settings.approval_timeout):
                await asyncio.shield(approval.refused)

    def _robot_of(self, action_name: str) -> str:
        return parent_of(self._catalog.place_of(action_name))

    def _is_simulated(self, action_name: str, robot: str) -> bool:
        """Whether an action can only be one of a simulated robot: it is in its namespace, and serves no other."""
        return action_name not in self._catalog.shared and self._simulated(robot)

    # ------------------------------------------------------------------ answers

    def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the approvals that wait and that a grant covers, oldest first."""
        return [each.document() for each in self._waiting.values() if grant.covers_action(each.action_name)]

    def get(self, approval_id: str, grant: Grant = UNLIMITED) -> Approval:
        """Return what waits.

        Raises:
            NotFound: It does not wait, or the grant does not cover it (`approval_not_found`).
        """
        approval = self._waiting.get(approval_id)
        if approval is None or approval.refused.done() or not grant.covers_action(approval.action_name):
            raise NotFound(
                "this goal does not wait for approval: it was answered, expired, or a stop has dropped it",
                code="approval_not_found",
            )
        return approval

    async def asked_by(self, principal: Principal) -> Approval:
        """Wait until a request of an agent waits for a person; return what waits.

        Args:
            principal: The very object that the request was authorized with.
        """
        while True:
            for approval in self._waiting.values():
                if approval.principal is principal:
                    return approval
            await self._asked.wait()

    def decide(self, approval_id: str, *, allow: bool, by: str | None) -> Approval:
        """Allow or refuse a goal.

        Raises:
            NotFound: It does not wait (`approval_not_found`).
        """
        approval = self.get(approval_id)
        refusal = NotAllowed(f"{by or 'a person'} has refused the goal", code="approval_refused")
        approval.answer(None if allow else refusal)
        return approval

    def drop(self, robot: str) -> None:
        """Drop what waits for a robot that is stopped, or for one below it."""
        for approval in self._waiting.values():
            if is_under(approval.robot, robot) or approval.action_name in self._catalog.shared:
                approval.answer(Conflict("a stop was requested while the goal waited for approval", code="stopped"))

    def _publish(self) -> None:
        if self._fanout.watched("approvals"):
            self._fanout.publish(fleet_event("approvals", utc_now(), narrow_approvals, approvals=self.documents()))

    async def close(self) -> None:
        """Drop what waits."""
        for approval in self._waiting.values():
            approval.answer(Unavailable("the gateway is shutting down", code="shutting_down"))


def _name_of(agent: Principal) -> str:
    """Return what an agent is called: its own name, or that of its program."""
    return agent.name or agent.client or "an agent without a name"
