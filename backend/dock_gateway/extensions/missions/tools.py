"""The tools of agents for missions: they queue, read, pause and end them. People continue them."""

from typing import Annotated

from pydantic import Field

from dock_gateway.access.carry_out import Fields
from dock_gateway.access.tool import Tool
from dock_gateway.core.access import Principal
from dock_gateway.core.namespace import read_namespace
from dock_gateway.extensions.missions import routes
from dock_gateway.extensions.missions.mission import MissionStatus
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.schema import Mission, MissionBody, MissionContent, MissionList
from dock_gateway.http.bodies import read_model
from dock_gateway.http.operation import carries_out
from dock_gateway.http.parts import Parts
from dock_gateway.http.requests import check_key
from dock_gateway.http.schema import Schema

MISSION_ID = r"^[0-9a-f]{32}$"


class CreateMissionArguments(MissionContent):
    """The arguments of `create_mission`."""

    robot: Annotated[
        str | None, Field(description="Namespace of the robot, such as `/robot1`. Default: the configured robot.")
    ] = None
    idempotency_key: Annotated[
        str | None,
        Field(max_length=200, description="Repeat a call that failed with the same text: there is then one mission."),
    ] = None


class OfMission(Schema):
    """A mission."""

    mission_id: Annotated[str, Field(pattern=MISSION_ID, description="`mission_id`, as the other tools return it")]


class ListMissionsArguments(Schema):
    """The arguments of `list_missions`."""

    robot: Annotated[str | None, Field(description="Only missions of this robot")] = None
    status: Annotated[MissionStatus | None, Field(description="Only missions in this state")] = None
    limit: Annotated[int, Field(ge=1, le=100, description="Number of missions, newest first")] = 20


class MissionAnswer(Schema):
    """A mission, as it is now."""

    mission: Mission


@carries_out(routes.create_mission)
async def create_mission(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Queue a mission for a robot, by an agent."""
    robot, key = fields.pop("robot", None), check_key(fields.pop("idempotency_key", None), "idempotency_key")
    body = read_model(MissionBody, {**fields, "by": principal.name})
    mission_id = routes.id_of(None if key is None else principal.own(key))
    return {"mission": await parts[Missions].add(mission_id, body, robot, principal.grant)}


@carries_out(routes.list_missions)
async def list_missions(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """List missions, newest first."""
    robot, status = fields.get("robot"), fields.get("status")
    page, end = await parts[Missions].book.page(
        None if robot is None else read_namespace(robot),
        frozenset() if status is None else frozenset({status}),
        principal.grant,
        fields["limit"],
        None,
    )
    return {"missions": page, "next_cursor": end and end.encode()}


@carries_out(routes.get_mission)
async def get_mission(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Return a mission."""
    return {"mission": await parts[Missions].book.document(fields["mission_id"], principal.grant)}


@carries_out(routes.pause_mission)
async def pause_mission(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """Hold a mission before its next step."""
    return {"mission": await parts[Missions].pause(fields["mission_id"], principal.grant)}


@carries_out(routes.cancel_mission)
async def cancel_mission(parts: Parts, principal: Principal, fields: Fields) -> Fields:
    """End a mission, after its goal was canceled."""
    return {"mission": await parts[Missions].cancel(fields["mission_id"], principal.grant)}


TOOLS = (
    Tool(
        "create_mission",
        "Create a mission",
        "Queue a list of steps that a robot takes one after the other: dock, undock, action, navigate, wait. "
        "A mission that moves a real robot is held (held_for: approval) until a person who has seen all of its steps "
        "continues it on the dashboard; no tool can do that. Follow it with get_mission.",
        create_mission,
        CreateMissionArguments,
        MissionAnswer,
        moves=True,
    ),
    Tool(
        "list_missions",
        "List missions",
        "List the missions of robots, newest first: their steps, what they wait for, and why they are held.",
        list_missions,
        ListMissionsArguments,
        MissionList,
        reads=True,
    ),
    Tool(
        "get_mission",
        "Get a mission",
        "Return a mission with its steps: how far it is, what it waits for, why it is held or has failed.",
        get_mission,
        OfMission,
        MissionAnswer,
        reads=True,
    ),
    Tool(
        "pause_mission",
        "Pause a mission",
        "Hold a mission before its next step. Only a person can let it go on: there is no tool for that.",
        pause_mission,
        OfMission,
        MissionAnswer,
        repeatable=True,
    ),
    Tool(
        "cancel_mission",
        "Cancel a mission",
        "End a mission; the goal of its step is canceled first. In an emergency use stop_robots.",
        cancel_mission,
        OfMission,
        MissionAnswer,
        repeatable=True,
    ),
)
