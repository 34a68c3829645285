"""`/automation`: the rules of automatic docking, and their decisions."""

from typing import Annotated

from fastapi import APIRouter, Depends, Query
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.extensions.automation.rule import RuleBody
from dock_gateway.extensions.automation.rules import DockingRules
from dock_gateway.extensions.automation.schema import DecisionList, HoldList, Rule, RuleList
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import (
    GOAL_ID,
    SLUG_IN_PATH,
    Answer,
    AnyRobotQuery,
    CursorQuery,
    LimitQuery,
    RobotQuery,
    end_of_page,
    json_response,
    read_goal_id,
    read_slug,
)
from dock_gateway.http.resource import ChangeCondition, Item, WriteCondition, item_response, removed
from dock_gateway.http.route import ApiRoute
from dock_gateway.robots.registry import RobotRegistry

router = APIRouter(route_class=ApiRoute, tags=["Automatic docking"], prefix="/automation")


async def _rule_id_in_path(rule_id: Annotated[str, SLUG_IN_PATH]) -> str:
    return read_slug(rule_id, "rule_id")


RuleId = Annotated[str, Depends(_rule_id_in_path)]
GoalIdQuery = Annotated[
    str | None,
    Query(description="Only the decision that sent this goal", json_schema_extra={"pattern": f"^{GOAL_ID.pattern}$"}),
]


@router.get("/rules")
@operation(Role.VIEWER, Scope.LISTED)
async def list_rules(rules: Part[DockingRules], grant: TheGrant) -> Answer[RuleList]:
    """List the rules by name, each with the robots that it applies to and what it waits for."""
    return json_response({"rules": await rules.documents(grant)})


@router.get("/rules/{rule_id}")
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def get_rule(rule_id: RuleId, rules: Part[DockingRules], grant: TheGrant) -> Item[Rule]:
    """Return a rule."""
    return item_response(await rules.document(rule_id, grant))


@router.put("/rules/{rule_id}")
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def replace_rule(
    rule_id: RuleId, body: SignedBody[RuleBody], rules: Part[DockingRules], condition: WriteCondition
) -> Item[Rule]:
    """Store a rule, new or changed, at every gateway that shares the history. It starts from the beginning.

    A rule is off unless `mode` says otherwise. It has one condition, `battery` or `schedule`.
    """
    rule, new = await rules.replace(rule_id, body.entry(), condition)
    return item_response(rule, f"{router.prefix}/rules/{rule_id}" if new else None)


@router.delete("/rules/{rule_id}", status_code=204)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def remove_rule(rule_id: RuleId, rules: Part[DockingRules], condition: ChangeCondition) -> Response:
    """Remove a rule. Goals that it sent go on."""
    return await removed(rules.remove(rule_id, condition))


@router.get("/decisions")
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def list_decisions(
    rules: Part[DockingRules],
    known_robots: Part[KnownRobots],
    grant: TheGrant,
    *,
    robot: AnyRobotQuery = None,
    rule: Annotated[str | None, Query(description="Id of a rule")] = None,
    goal_id: GoalIdQuery = None,
    limit: LimitQuery = 50,
    cursor: CursorQuery = None,
) -> Answer[DecisionList]:
    """List the decisions of all gateways that share the history, newest first. The last 1000 are kept."""
    namespace = None if robot is None else read_namespace(robot)
    await known_robots.require(robot, grant, rules.decisions.has)
    found, end = await rules.decisions.page(
        robot=namespace,
        rule_id=rule,
        goal_id=None if goal_id is None else read_goal_id(goal_id),
        limit=limit,
        end=end_of_page(cursor),
        grant=grant,
    )
    return json_response({"decisions": found, "next_cursor": end and end.encode()})


@router.get("/holds")
@operation(Role.VIEWER, Scope.LISTED)
async def list_holds(rules: Part[DockingRules], grant: TheGrant) -> Answer[HoldList]:
    """List the robots that were stopped while a rule was on: their automatic docking waits until it is continued."""
    stops = rules.last_stops.all_at().items()
    holds = [{"robot": robot, "held_at": at} for robot, at in stops if grant.covers_robot(robot)]
    return json_response({"holds": holds})


@router.delete("/holds", status_code=204)
@operation(Role.SUPERVISOR, Scope.ROBOT, errors=(404,))
async def end_hold(rules: Part[DockingRules], robots: Part[RobotRegistry], robot: RobotQuery = None) -> Response:
    """Continue the automatic docking of a robot that was stopped; also if it does not wait. Release the stop first."""
    await rules.last_stops.allow(robots.find(robot))
    return Response(status_code=204)
