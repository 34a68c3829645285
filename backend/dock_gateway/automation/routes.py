"""`/automation`: the rules of automatic docking, and their decisions."""

import re
from typing import Annotated
from zoneinfo import ZoneInfo

from fastapi import APIRouter, Depends, Query, Request
from starlette.responses import Response

from dock_gateway.automation.schema import RULE_EXAMPLE, SCHEDULE_EXAMPLE, DecisionList, RuleList
from dock_gateway.automation.schema import Rule as RuleSchema
from dock_gateway.core.automation import WEEKDAYS, Mode, Rule
from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.event import utc_now
from dock_gateway.core.namespace import read_namespace
from dock_gateway.http.fields import (
    ROBOTS_REQUEST,
    SLUG_IN_PATH,
    read_choice,
    read_part,
    read_robots,
    read_slug,
    read_texts,
)
from dock_gateway.http.openapi import body
from dock_gateway.http.principal import TheGrant, read_signed_json
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    GOAL_ID,
    LimitQuery,
    RobotQuery,
    TheGateway,
    json_response,
    known_query,
    name_schema,
    read_goal_id,
    read_name,
    read_object,
)

router = APIRouter(tags=["Automatic docking"], prefix="/automation")

NO_QUERY = Depends(known_query())
FIELDS = ("name", "mode", "robots", "battery", "schedule", "by")
MAX_NAME = 60
MAX_TIMES = 24
MIN_IDLE, MAX_IDLE = 10.0, 86_400.0  # seconds
TIME = re.compile(r"(?:[01][0-9]|2[0-3]):[0-5][0-9]")
ZONE = re.compile(r"[A-Za-z][A-Za-z0-9_+-]*(?:/[A-Za-z0-9_+-]+){0,2}")
MAX_ZONE = 60
RULE_REQUEST = {
    "type": "object",
    "required": ["name", "robots"],
    "additionalProperties": False,
    "properties": {
        "name": name_schema(MAX_NAME),
        "mode": {"enum": [mode.value for mode in Mode], "description": "`off` by default"},
        "robots": ROBOTS_REQUEST,
        "battery": {
            "type": ["object", "null"],
            "description": "Either this or `schedule`",
            "required": ["below", "idle_s"],
            "additionalProperties": False,
            "properties": {
                "below": {"type": "number", "exclusiveMinimum": 0, "maximum": 1, "description": "Charge, 0 to 1"},
                "idle_s": {"type": "number", "minimum": MIN_IDLE, "maximum": MAX_IDLE, "description": "Seconds"},
            },
        },
        "schedule": {
            "type": ["object", "null"],
            "required": ["times", "weekdays", "time_zone"],
            "additionalProperties": False,
            "properties": {
                "times": {
                    "type": "array",
                    "minItems": 1,
                    "maxItems": MAX_TIMES,
                    "items": {"type": "string", "pattern": f"^{TIME.pattern}$"},
                },
                "weekdays": {"type": "array", "minItems": 1, "maxItems": 7, "items": {"enum": list(WEEKDAYS)}},
                "time_zone": {
                    "type": "string",
                    "maxLength": MAX_ZONE,
                    "pattern": f"^{ZONE.pattern}$",
                    "description": "IANA name, such as Europe/Berlin",
                },
            },
        },
        "by": name_schema(MAX_NAME) | {"type": ["string", "null"], "description": "Who changes the rule"},
    },
    "examples": [RULE_EXAMPLE, SCHEDULE_EXAMPLE],
}


async def _rule_id_in_path(rule_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(rule_id, "rule_id")


RuleId = Annotated[str, Depends(_rule_id_in_path)]
GoalIdQuery = Annotated[
    str | None,
    Query(description="Only the decision that sent this goal", json_schema_extra={"pattern": f"^{GOAL_ID.pattern}$"}),
]


@router.get("/rules", response_model=RuleList, responses=problems(422, 503), dependencies=[NO_QUERY])
async def list_rules(gateway: TheGateway, grant: TheGrant) -> Response:
    """List the rules by name, each with the robots that it applies to and what it waits for."""
    return json_response({"rules": await gateway.automation.documents(grant)})


@router.put(
    "/rules/{rule_id}",
    response_model=RuleSchema,
    responses=problems(400, 408, 409, 413, 415, 422, 503),
    dependencies=[NO_QUERY],
    openapi_extra=body(RULE_REQUEST, required=True),
)
async def replace_rule(rule_id: RuleId, request: Request, gateway: TheGateway) -> Response:
    """Store a rule, new or changed, at every gateway that shares the history. It starts from the beginning.

    A rule is off unless `mode` says otherwise. It has one condition, `battery` or `schedule`.
    """
    rule = read_rule(await read_signed_json(request))
    return json_response(await gateway.automation.replace(rule_id, rule))


@router.delete("/rules/{rule_id}", status_code=204, responses=problems(404, 422, 503), dependencies=[NO_QUERY])
async def remove_rule(rule_id: RuleId, gateway: TheGateway) -> Response:
    """Remove a rule. Goals that it sent go on."""
    await gateway.automation.remove(rule_id)
    return Response(status_code=204)


@router.get(
    "/decisions",
    response_model=DecisionList,
    responses=problems(422, 503),
    dependencies=[Depends(known_query("robot", "rule", "goal_id", "limit"))],
)
async def list_decisions(
    gateway: TheGateway,
    grant: TheGrant,
    *,
    robot: RobotQuery = None,
    rule: Annotated[str | None, Query(description="Id of a rule")] = None,
    goal_id: GoalIdQuery = None,
    limit: LimitQuery = 50,
) -> Response:
    """List the decisions of all gateways that share the history, newest first. The last 1000 are kept."""
    found = await gateway.automation.decisions.newest(
        robot=None if robot is None else read_namespace(robot),
        rule_id=rule,
        goal_id=None if goal_id is None else read_goal_id(goal_id),
        limit=limit,
        grant=grant,
    )
    return json_response({"decisions": found})


# ---------------------------------------------------------------------- reading a rule


def read_rule(value: object) -> Rule:
    """Read a rule from a decoded body.

    Raises:
        InvalidField: It is not a rule.
    """
    fields = read_object(value, *FIELDS)
    by = fields.get("by")
    everyone, robots, groups = read_robots(fields.get("robots"))
    battery, schedule = fields.get("battery"), fields.get("schedule")
    if (battery is None) is (schedule is None):
        detail = "got neither" if battery is None else "got both"
        raise InvalidField([FieldError("battery", "one condition, `battery` or `schedule`", detail)])
    below, idle_s = (None, None) if battery is None else _read_battery(battery)
    times, weekdays, zone = ((), (), None) if schedule is None else _read_schedule(schedule)
    return Rule(
        name=read_name(fields.get("name"), MAX_NAME, "name"),
        mode=Mode(read_choice(fields.get("mode", "off"), tuple(mode.value for mode in Mode), "mode")),
        every_robot=everyone,
        robots=robots,
        groups=groups,
        below=below,
        idle_s=idle_s,
        times=times,
        weekdays=weekdays,
        time_zone=zone,
        changed_by=None if by is None else read_name(by, MAX_NAME),
        changed_at=utc_now(),
    )


def _read_battery(value: object) -> tuple[float, float]:
    fields = read_part(value, "battery", "below", "idle_s")
    below = _read_number(fields.get("below"), "battery.below", 0.0, 1.0)
    if below == 0:
        raise InvalidField([FieldError("battery.below", "a number above 0, up to 1", "got 0")])
    return below, _read_number(fields.get("idle_s"), "battery.idle_s", MIN_IDLE, MAX_IDLE)


def _read_schedule(value: object) -> tuple[tuple[str, ...], tuple[str, ...], str]:
    fields = read_part(value, "schedule", "times", "weekdays", "time_zone")
    times = read_texts(fields.get("times"), "schedule.times", MAX_TIMES, "times of day", at_least=1)
    for index, time in enumerate(times):
        if not TIME.fullmatch(time):
            raise InvalidField([FieldError(f"schedule.times.{index}", "HH:MM from 00:00 to 23:59", got(time))])
    weekdays = read_texts(fields.get("weekdays"), "schedule.weekdays", len(WEEKDAYS), "days", at_least=1)
    for index, day in enumerate(weekdays):
        read_choice(day, WEEKDAYS, f"schedule.weekdays.{index}")
    zone = fields.get("time_zone")
    if not isinstance(zone, str) or not _is_zone(zone):
        raise InvalidField([FieldError("schedule.time_zone", "an IANA time zone, such as Europe/Berlin", got(zone))])
    ordered = tuple(day for day in WEEKDAYS if day in weekdays)
    return tuple(sorted(set(times))), ordered, zone


def _is_zone(name: str) -> bool:
    if len(name) > MAX_ZONE or not ZONE.fullmatch(name):
        return False
    try:
        ZoneInfo(name)
    except (KeyError, ValueError, OSError):  # a folder or another file is not a time zone, either
        return False
    return True


def _read_number(value: object, path: str, lowest: float, highest: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not lowest <= value <= highest:
        raise InvalidField([FieldError(path, f"a number from {lowest:g} to {highest:g}", got(value))])
    return float(value)
