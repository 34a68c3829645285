"""`/goals/{goal_id}/notes` and `/tags`: what people write about a goal. `/goals/{goal_id}` has it, too."""

import uuid
from collections.abc import Collection
from datetime import UTC, datetime
from typing import Annotated

from fastapi import APIRouter, Path
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.schema import GoalTags, NoteBody, Tags, TagsBody
from dock_gateway.goals.schema import Note as NoteAnswer
from dock_gateway.http.bodies import Body, SignedBody
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, GoalId, json_response
from dock_gateway.http.resource import ChangeCondition, Item, item_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.storage import History, Note
from dock_gateway.storage.notes import etag_of

router = APIRouter(route_class=ApiRoute, tags=["Goals"], prefix="/goals")

NoteId = Annotated[str, Path(description="`note_id` of the note", pattern="^[0-9a-f]{32}$")]


@router.get("/tags", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.ANY)
async def list_tags(history: Part[History]) -> Answer[Tags]:
    """List the tags of all goals, the first 1000."""
    return json_response({"tags": await history.notes.all_tags()})


@router.post("/{goal_id}/notes", status_code=201)
@operation(Role.OPERATOR, Scope.GOAL, errors=(409,))
async def add_note(
    goal_id: GoalId, body: SignedBody[NoteBody], goals: Part[Goals], history: Part[History]
) -> Answer[NoteAnswer]:
    """Add a note to a goal, which may have 100. Returns the note."""
    await goals.get(goal_id)
    note = Note(uuid.uuid4().hex, body.by, datetime.now(UTC), body.text)
    await history.notes.add(goal_id, note)
    return json_response(note, 201)


@router.delete("/{goal_id}/notes/{note_id}", status_code=204)
@operation(Role.OPERATOR, Scope.GOAL)
async def delete_note(goal_id: GoalId, note_id: NoteId, goals: Part[Goals], history: Part[History]) -> Response:
    """Delete a note of a goal. Succeeds even if there is no such note."""
    await goals.get(goal_id)
    await history.notes.remove(goal_id, note_id)
    return Response(status_code=204)


@router.get("/{goal_id}/tags")
@operation(Role.VIEWER, Scope.GOAL)
async def get_tags(goal_id: GoalId, goals: Part[Goals], history: Part[History]) -> Item[GoalTags]:
    """Return the tags of a goal, in alphabetical order."""
    await goals.get(goal_id)
    return _answer_tags((await history.notes.tags_of([goal_id])).get(goal_id, ()))


@router.put("/{goal_id}/tags")
@operation(Role.OPERATOR, Scope.GOAL)
async def replace_tags(
    goal_id: GoalId, body: Body[TagsBody], goals: Part[Goals], history: Part[History], condition: ChangeCondition
) -> Item[GoalTags]:
    """Replace the tags of a goal. Returns them in alphabetical order."""
    await goals.get(goal_id)
    await history.notes.replace_tags(goal_id, body.tags, condition)
    return _answer_tags(body.tags)


def _answer_tags(tags: Collection[str]) -> Item[GoalTags]:
    return item_response({"tags": sorted(tags), "etag": etag_of(tags)})
