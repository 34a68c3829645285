"""What an OpenAPI document cannot say: requests that fit it, and are refused with a reason all the same."""

import os
from collections.abc import Mapping
from datetime import UTC, datetime

import schemathesis

from dock_gateway.http.resource import TAGS


@schemathesis.hook
def filter_case(_: schemathesis.HookContext, case: schemathesis.Case) -> bool:
    """Leave out what no schema can rule out."""
    return _has_entity_tags(case.headers or {}) and _fits(case)


def _fits(case: schemathesis.Case) -> bool:
    query = case.query or {}
    if case.operation.path == "/battery/history":
        return not _is_reversed(query)
    if case.operation.path == "/statistics":  # most patterns are no time zone, and most spans are more than 400 days
        return not _is_reversed(query) and "time_zone" not in query and query.get("by") in ("robot", "action")
    if case.operation.path == "/stop":
        return not _names_two_robots(query, case.body)
    if case.operation.path == "/tokens":
        return not _limits_an_admin(case.body)
    if case.operation.path == "/users/{user}" and isinstance(case.body, dict):  # a new user needs a password
        return "password" in case.body and not _limits_an_admin(case.body)
    return "cursor" not in query and not _names_two_docks(case.body)  # a cursor comes out of an answer


# What needs no credentials.
PUBLIC = {("GET", "/healthz"), ("GET", "/readyz"), ("GET", "/session"), ("DELETE", "/session")}


@schemathesis.check
def refused_without_token(
    _: schemathesis.CheckContext, response: schemathesis.Response, case: schemathesis.Case
) -> None:
    """A request without credentials is refused. Only for a run that has none."""
    if "WITHOUT_CREDENTIALS" not in os.environ or (case.method, case.operation.path) in PUBLIC:
        return
    if case.method == "OPTIONS" and response.status_code == 204:
        return  # which methods there are is no secret: the document says it
    if response.status_code == 404 and response.json()["code"] == "not_found":
        return  # a path that leads to no operation, such as one with a line break in a name
    if case.operation.path.startswith("/session/oidc"):  # without an identity provider
        allowed: tuple[int, ...] = (401, 404, 405, 422)
    elif case.operation.path == "/session":
        allowed = (400, 401, 405, 415, 422, 429)
    else:
        allowed = (401, 405)
    assert response.status_code in allowed, f"{response.status_code}: {response.text}"


def _has_entity_tags(headers: Mapping[str, object]) -> bool:
    """What is made up for `If-Match` does not have its pattern always."""
    return "If-Match" not in headers or TAGS.fullmatch(str(headers["If-Match"])) is not None


def _names_two_docks(body: object) -> bool:
    """A dock may be named by `dock_id` or by the desired battery state, but not another one by each."""
    if not isinstance(body, dict) or not isinstance(state := body.get("desired_battery_state"), dict):
        return False
    return "dock_id" in body and bool(state.get("location")) and state["location"] != body["dock_id"]


def _names_two_robots(query: dict[str, object], body: object) -> bool:
    """A robot may be named in the query or in the body of a stop, but not another one in each."""
    named = body.get("robot") if isinstance(body, dict) else None
    return named is not None and "robot" in query and query["robot"] != named


def _limits_an_admin(body: object) -> bool:
    """An admin can change any limit."""
    limits = ("robots", "actions", "topics")
    return isinstance(body, dict) and body.get("role") == "admin" and any(body.get(name) for name in limits)


def _is_reversed(query: dict[str, object]) -> bool:
    """A span of time has `since` before `until`, which is now where it is left out."""
    try:
        since = datetime.fromisoformat(str(query["since"]))
        return since >= datetime.fromisoformat(str(query.get("until", datetime.now(UTC).isoformat())))
    except (KeyError, ValueError, TypeError):
        return False
