"""`/goals/{goal_id}/notes` and `/tags`: what people write about a goal."""

import re
import uuid
from datetime import UTC, datetime
from typing import Annotated

from fastapi import APIRouter, Depends, Path, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.goals.schema import NOTE_EXAMPLE, GoalNotes, Tags
from dock_gateway.http.openapi import body
from dock_gateway.http.principal import read_signed_json
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    MAX_TAG,
    GoalId,
    TheGateway,
    json_response,
    known_query,
    name_schema,
    read_json,
    read_name,
    read_names,
    read_object,
)
from dock_gateway.storage import Note

router = APIRouter(tags=["Goals"], prefix="/goals", dependencies=[Depends(known_query())])

MAX_NAME, MAX_TEXT, MAX_TAGS = 60, 2000, 10
# Lines of text: no control characters but line feeds and tabs; not blank.
_CONTROL = r"\x00-\x08\x0b-\x1f\x7f-\x9f"
TEXT = re.compile(rf"[^{_CONTROL}]*[^\s{_CONTROL}][^{_CONTROL}]*")
NOTE_REQUEST = {
    "type": "object",
    "required": ["by", "text"],
    "additionalProperties": False,
    "properties": {
        "by": name_schema(MAX_NAME) | {"description": "Who writes it"},
        "text": {"type": "string", "maxLength": MAX_TEXT, "pattern": f"^{TEXT.pattern}$"},
    },
    "examples": [NOTE_EXAMPLE],
}
TAGS_REQUEST = {
    "type": "object",
    "required": ["tags"],
    "additionalProperties": False,
    "properties": {"tags": {"type": "array", "maxItems": MAX_TAGS, "items": name_schema(MAX_TAG)}},
    "examples": [{"tags": ["blocked", "maintenance"]}],
}
NoteId = Annotated[str, Path(description="`note_id` of the note", pattern="^[0-9a-f]{32}$")]


@router.get("/tags", response_model=Tags, responses=problems(422, 503))
async def list_tags(gateway: TheGateway) -> Response:
    """List the tags of all goals, the first 1000."""
    return json_response({"tags": await gateway.history.notes.all_tags()})


@router.get("/{goal_id}/notes", response_model=GoalNotes, responses=problems(404, 422, 503))
async def list_notes(goal_id: GoalId, gateway: TheGateway) -> Response:
    """Return the tags and notes of a goal."""
    await gateway.goal(goal_id)
    return json_response(await gateway.history.notes.of(goal_id))


@router.post(
    "/{goal_id}/notes",
    status_code=201,
    response_model=GoalNotes,
    responses=problems(400, 404, 408, 409, 413, 415, 422, 503),
    openapi_extra=body(NOTE_REQUEST, required=True),
)
async def add_note(goal_id: GoalId, request: Request, gateway: TheGateway) -> Response:
    """Add a note to a goal, which may have 100."""
    fields = read_object(await read_signed_json(request), "by", "text")
    by, text = read_name(fields.get("by"), MAX_NAME), read_text(fields.get("text"))
    await gateway.goal(goal_id)
    note = Note(uuid.uuid4().hex, by, datetime.now(UTC), text)
    return json_response(await gateway.history.notes.add(goal_id, note), 201)


@router.delete("/{goal_id}/notes/{note_id}", response_model=GoalNotes, responses=problems(404, 422, 503))
async def delete_note(goal_id: GoalId, note_id: NoteId, gateway: TheGateway) -> Response:
    """Delete a note of a goal."""
    await gateway.goal(goal_id)
    return json_response(await gateway.history.notes.remove(goal_id, note_id))


@router.put(
    "/{goal_id}/tags",
    response_model=GoalNotes,
    responses=problems(400, 404, 408, 413, 415, 422, 503),
    openapi_extra=body(TAGS_REQUEST, required=True),
)
async def replace_tags(goal_id: GoalId, request: Request, gateway: TheGateway) -> Response:
    """Replace the tags of a goal."""
    fields = read_object(await read_json(request), "tags")
    tags = read_names(fields.get("tags"), MAX_TAGS, MAX_TAG, "tags")
    await gateway.goal(goal_id)
    return json_response(await gateway.history.notes.replace_tags(goal_id, tags))


def read_text(value: object) -> str:
    """Return the text of a note with lines that end in a line feed, without surrounding space.

    Raises:
        InvalidField: It is not a text of that length.
    """
    text = value.replace("\r\n", "\n") if isinstance(value, str) else ""
    if len(text) > MAX_TEXT or not TEXT.fullmatch(text):
        detail = f"got {len(text)} characters" if len(text) > MAX_TEXT else got(value)
        expected = f"1 to {MAX_TEXT} characters, without control characters"
        raise InvalidField([FieldError("text", expected, detail)])
    return text.strip()
