"""One call of a tool: allowed, audited and carried out as a command of `/ws`. The caller may be asked a question."""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from mcp.server.context import ServerRequestContext
from mcp_types import (
    CallToolRequestParams,
    ElicitRequest,
    ElicitRequestFormParams,
    ElicitResult,
    InputRequiredResult,
)
from mcp_types.version import MODERN_PROTOCOL_VERSIONS
from starlette.requests import Request

from dock_gateway.access.carry_out import Command, Fields, carry_out
from dock_gateway.access.tool import Tool
from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.errors import NotFound
from dock_gateway.extensions.agents.reading import follow, goal_document
from dock_gateway.extensions.agents.schema import GoalAnswer
from dock_gateway.extensions.agents.settings import AgentSettings
from dock_gateway.extensions.agents.tools import STOP_TOOL, answer_approval
from dock_gateway.goals.approvals import Approval, Approvals
from dock_gateway.goals.goals import Goals
from dock_gateway.http.parts import Parts, parts_of
from dock_gateway.http.principal import principal_of
from dock_gateway.settings import Settings

Context = ServerRequestContext[Any, Request]
# Where the scope of a request has the stop that it asks for.
STOPPING = "stopping"
# Characters of the name of an agent's program.
MAX_CLIENT = 100
# Calls of one user that have asked back: as many as may wait for an answer, and those that are answered.
MAX_OPEN = 20
# The question to the person who uses an agent, and the field of their answer.
QUESTION, ALLOW = "approval", "allow"
FORM = {
    "type": "object",
    "properties": {ALLOW: {"type": "boolean", "title": "Allow", "description": "Whether the robot may move now"}},
    "required": [ALLOW],
}


@dataclass(frozen=True)
class Question:
    """A call that has asked the person who uses the agent. Its command waits for the answer, or for another one.

    Attributes:
        approval: What the command waits for.
        command: Carries out the command; its fields are those that were asked about.
    """

    approval: Approval
    tool: str
    arguments: Any
    command: "asyncio.Task[Fields]"

    @property
    def user(self) -> tuple[str | None, str]:
        """The user for whom the agent acts."""
        return self.approval.principal.name, self.approval.principal.address

    def is_of(self, principal: Principal, params: CallToolRequestParams) -> bool:
        """Whether a call is the same one again: by the same agent, with the same arguments."""
        same = (self.tool, self.arguments) == (params.name, params.arguments)
        return same and self.approval.principal.login == principal.login


class Questions:
    """The calls that have asked back, by the approvals that they wait for."""

    def __init__(self) -> None:
        self._open: dict[str, Question] = {}

    def ask(self, question: Question) -> None:
        """Keep a call until it is repeated. Those that never are make room for later ones of the same user."""
        own = [identity for identity, each in self._open.items() if each.user == question.user]
        for oldest in own[: max(0, len(own) + 1 - MAX_OPEN)]:
            del self._open[oldest]
        self._open[question.approval.id] = question

    def take(self, principal: Principal, params: CallToolRequestParams) -> Question:
        """Return the call that is repeated, once.

        Raises:
            NotFound: There is none (`approval_not_found`).
        """
        question = self._open.get(params.request_state or "")
        if question is None or not question.is_of(principal, params):
            raise NotFound("this call has asked for no approval, or it was repeated before", code="approval_not_found")
        del self._open[params.request_state or ""]
        return question


class Call:
    """A call of a tool.

    Args:
        context: The request.
        tool: The tool.
        params: What it says.
        questions: The calls that have asked back.
    """

    def __init__(self, context: Context, tool: Tool, params: CallToolRequestParams, questions: Questions) -> None:
        request = context.request
        assert request is not None
        self._context = context
        self._tool = tool
        self._params = params
        self._questions = questions
        self._parts: Parts = parts_of(request)
        self._client = _client_of(context, request)
        self._principal: Principal = principal_of(request).as_agent(self._client)
        self._scope = {**request.scope, "principal": self._principal}

    async def carry_out(self) -> Fields | InputRequiredResult:
        """Carry out the call; return its answer, or a question for the person who uses the agent.

        The command goes on if the client disconnects.

        Raises:
            GatewayError: It was refused or failed.
        """
        if self._tool.name == STOP_TOOL:
            return await self._stopped()
        fields = self._tool.read(self._params.arguments)
        wait = fields.pop("wait_seconds", 0.0)
        if self._params.request_state is not None:
            command = await self._take_answer()
        else:
            fields = await self._tool.prepare(self._parts, self._principal, fields)
            tool = self._tool
            command = asyncio.create_task(self._carry_out(tool.command, fields, self._client))
            command.add_done_callback(_retrieve)
            if (approval := await self._asked(command)) is not None:
                return self._ask(approval, command)
        answer = await asyncio.shield(command)
        return answer if self._tool.returns is not GoalAnswer else await self._end_of(answer["goal"]["goal_id"], wait)

    async def _stopped(self) -> Fields:
        """Return the answer of a stop, which was carried out when the message came."""
        stopping: asyncio.Task[Fields] | None = self._scope.get(STOPPING)
        if stopping is None:  # the message was read in another way then
            return await self._carry_out(self._tool.command, self._params.arguments or {}, self._client)
        return await asyncio.shield(stopping)

    async def _carry_out(self, command: Command, fields: Fields, subject: str) -> Fields:
        return await carry_out(self._parts, self._principal, command, fields, self._scope, subject=subject)

    async def _end_of(self, goal_id: str, seconds: float) -> Fields:
        """Return a goal; before that, wait for its end."""
        if seconds:
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await follow(self._parts, self._principal, goal_id, self._report)
        goal = await self._parts[Goals].get(goal_id, self._principal.grant)
        return {"goal": goal_document(goal)}

    async def _report(self, reports: int, text: str) -> None:
        await self._context.session.report_progress(float(reports), message=text)

    # ------------------------------------------------------------------ asking back

    def _may_ask(self) -> bool:
        """Whether the person who uses the agent can be asked, and their answer counts."""
        settings, session = self._parts[Settings], self._context.session
        capabilities = session.client_capabilities
        asks = capabilities is not None and capabilities.elicitation is not None
        open_here = not settings.authentication and self._principal.kind is not PrincipalKind.FORWARDED
        counts = settings.of(AgentSettings).approval_by_client or open_here
        return asks and counts and session.protocol_version in MODERN_PROTOCOL_VERSIONS

    async def _asked(self, command: "asyncio.Task[Fields]") -> Approval | None:
        """Wait until a command has ended, or waits for a person who can be asked here; return what it waits for."""
        if not self._tool.moves or not self._may_ask():
            return None
        asked = asyncio.create_task(self._parts[Approvals].asked_by(self._principal))
        try:
            await asyncio.wait({command, asked}, return_when=asyncio.FIRST_COMPLETED)
            return asked.result() if asked.done() else None
        finally:
            asked.cancel()

    def _ask(self, approval: Approval, command: "asyncio.Task[Fields]") -> InputRequiredResult:
        self._questions.ask(Question(approval, self._params.name, self._params.arguments, command))
        what = (
            f"send a goal to {approval.action_name}" if approval.verb is None else f"{approval.verb} {approval.robot}"
        )
        text = f"{approval.agent} wants to {what}. Check that the area is clear."
        form = ElicitRequestFormParams(message=text, requested_schema=FORM)
        requests = {QUESTION: ElicitRequest(params=form)}
        return InputRequiredResult(input_requests=requests, request_state=approval.id)

    async def _take_answer(self) -> "asyncio.Task[Fields]":
        """Take the person's answer; return the command that has waited for it. Without an answer it waits on."""
        question = self._questions.take(self._principal, self._params)
        answer = (self._params.input_responses or {}).get(QUESTION)
        if isinstance(answer, ElicitResult) and answer.action != "cancel":
            content: Mapping[str, object] = answer.content or {}
            allow = answer.action == "accept" and content.get(ALLOW) is True
            approval = question.approval
            fields = {"approval_id": approval.id, "action": approval.action_name, "allow": allow}
            subject = f"{'allowed' if allow else 'refused'} in {self._client}"
            with suppress(NotFound):  # it was answered elsewhere meanwhile, which counts
                await self._carry_out(answer_approval, fields, subject)
        return question.command


def _retrieve(command: "asyncio.Task[Fields]") -> None:
    """Take note of the error of a command whose call was never repeated."""
    if not command.cancelled():
        command.exception()


def _client_of(context: Context, request: Request) -> str:
    """Return what the agent's program calls itself."""
    params = context.session.client_params
    if params is not None:
        name = f"{params.client_info.name} {params.client_info.version}"
        return _one_line(name)
    return client_name(request)


def client_name(request: Request) -> str:
    """Return what the program that sends a request calls itself in its headers."""
    return _one_line(request.headers.get("user-agent", "a program without a name"))


def _one_line(name: str) -> str:
    return " ".join(name.split())[:MAX_CLIENT]
