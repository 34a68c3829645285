"""`/approvals`: agents' goals to real robots, which wait until a person allows them."""

from typing import Annotated

from fastapi import APIRouter, Path, Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.grant import Role
from dock_gateway.goals.approval_schema import Approval, ApprovalBody, ApprovalList
from dock_gateway.goals.approvals import Approvals
from dock_gateway.http.bodies import Body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant, ThePrincipal
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Approvals"], prefix="/approvals")

ApprovalId = Annotated[str, Path(description="`approval_id` of what waits")]


@router.get("")
@operation(Role.VIEWER, Scope.LISTED)
async def list_approvals(approvals: Part[Approvals], grant: TheGrant) -> Answer[ApprovalList]:
    """List the goals of agents that wait until a person allows them, oldest first."""
    return json_response({"approvals": approvals.documents(grant)})


@router.get("/{approval_id}")
@operation(Role.VIEWER, Scope.APPROVAL)
async def get_approval(approval_id: ApprovalId, approvals: Part[Approvals], grant: TheGrant) -> Answer[Approval]:
    """Return a goal that waits until a person allows it."""
    return json_response(approvals.get(approval_id, grant).document())


@router.put("/{approval_id}/decision")
@operation(Role.OPERATOR, Scope.APPROVAL)
async def decide_approval(
    approval_id: ApprovalId,
    body: Body[ApprovalBody],
    request: Request,
    approvals: Part[Approvals],
    principal: ThePrincipal,
) -> Answer[Approval]:
    """Allow or refuse a goal that waits: this goal, once. It is sent at once if it is allowed.

    The first decision holds. A goal that has expired, was decided on or was dropped by a stop is
    `404 approval_not_found`.
    """
    allow = body.allow
    approval = approvals.decide(approval_id, allow=allow, by=principal.name)
    subject = f"{'allowed' if allow else 'refused'} {approval.agent}"
    audited(request, robot=approval.robot, action_name=approval.action_name, subject=subject)
    return json_response(approval.document())
