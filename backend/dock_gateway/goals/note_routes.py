"""`/goals/{goal_id}/notes` and `/tags`: what people write about a goal."""

import uuid
from datetime import UTC, datetime
from typing import Annotated

from fastapi import APIRouter, Path, Request
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.schema import GoalNotes, NoteBody, Tags, TagsBody
from dock_gateway.http.bodies import body_schema, read, read_signed
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    NO_QUERY,
    GoalId,
    json_response,
)
from dock_gateway.storage import History, Note

router = APIRouter(tags=["Goals"], prefix="/goals", dependencies=[NO_QUERY])

NoteId = Annotated[str, Path(description="`note_id` of the note", pattern="^[0-9a-f]{32}$")]


@router.get("/tags", response_model=Tags, responses=problems(422, 503))
@operation(Role.VIEWER, Scope.ANY)
async def list_tags(history: Part[History]) -> Response:
    """List the tags of all goals, the first 1000."""
    return json_response({"tags": await history.notes.all_tags()})


@router.get("/{goal_id}/notes", response_model=GoalNotes, responses=problems(404, 422, 503))
@operation(Role.VIEWER, Scope.GOAL)
async def list_notes(goal_id: GoalId, goals: Part[Goals], history: Part[History]) -> Response:
    """Return the tags and notes of a goal."""
    await goals.get(goal_id)
    return json_response(await history.notes.of(goal_id))


@router.post(
    "/{goal_id}/notes",
    status_code=201,
    response_model=GoalNotes,
    responses=problems(400, 404, 408, 409, 413, 415, 422, 503),
    openapi_extra=body(body_schema(NoteBody), required=True),
)
@operation(Role.OPERATOR, Scope.GOAL)
async def add_note(goal_id: GoalId, request: Request, goals: Part[Goals], history: Part[History]) -> Response:
    """Add a note to a goal, which may have 100."""
    body = await read_signed(NoteBody, request)
    await goals.get(goal_id)
    note = Note(uuid.uuid4().hex, body.by, datetime.now(UTC), body.text)
    return json_response(await history.notes.add(goal_id, note), 201)


@router.delete("/{goal_id}/notes/{note_id}", response_model=GoalNotes, responses=problems(404, 422, 503))
@operation(Role.OPERATOR, Scope.GOAL)
async def delete_note(goal_id: GoalId, note_id: NoteId, goals: Part[Goals], history: Part[History]) -> Response:
    """Delete a note of a goal."""
    await goals.get(goal_id)
    return json_response(await history.notes.remove(goal_id, note_id))


@router.put(
    "/{goal_id}/tags",
    response_model=GoalNotes,
    responses=problems(400, 404, 408, 413, 415, 422, 503),
    openapi_extra=body(body_schema(TagsBody), required=True),
)
@operation(Role.OPERATOR, Scope.GOAL)
async def replace_tags(goal_id: GoalId, request: Request, goals: Part[Goals], history: Part[History]) -> Response:
    """Replace the tags of a goal."""
    body = await read(TagsBody, request)
    await goals.get(goal_id)
    return json_response(await history.notes.replace_tags(goal_id, body.tags))
