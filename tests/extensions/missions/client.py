"""`/missions` of a gateway whose missions nobody carries out."""

from types import SimpleNamespace
from typing import Any, cast

import orjson

from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.allow_list import AllowList
from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.missions.actions import covers
from dock_gateway.extensions.missions.book import MissionBook
from dock_gateway.extensions.missions.messages import Messages
from dock_gateway.extensions.missions.mission import MissionEntry
from dock_gateway.extensions.missions.missions import Missions
from dock_gateway.extensions.missions.places.place import PlaceEntry
from dock_gateway.extensions.missions.places.places import MAX_PLACES, Places
from dock_gateway.extensions.missions.schedules.schedule import ScheduleEntry
from dock_gateway.extensions.missions.schedules.schedules import BY_THEMSELVES, MAX_SCHEDULES, Schedules
from dock_gateway.extensions.missions.templates.template import TemplateEntry
from dock_gateway.extensions.missions.templates.templates import MAX_TEMPLATES, Templates
from dock_gateway.extensions.missions.tools import TOOLS
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.graph.publishing import FoundTopic, Publishing
from dock_gateway.graph.service_calls import FoundService, ServiceCalls
from dock_gateway.stop.last_stops import LastStop, LastStops
from dock_gateway.storage.shared_entries import SharedBook
from tests.support.history import HistoryInMemory
from tests.support.robot_actions import make_known_robots
from tests.support.route_client import RouteClient

AGENT = Principal("planner", PrincipalKind.TOKEN, Grant(Role.AGENT), "a")
PLAIN = {"steps": [{"dock": {}}, {"wait": {"seconds": 2}}, {"undock": {}}]}


class Services:
    """The service `/reset`, which may be called, and another one that may not; `/later` may be and is not there."""

    listed = AllowList("allow_services", ["/reset", "/later", "/robot2/**"], "the gateway does not call the service")

    async def find(self, name: str, type_name: str | None) -> FoundService:
        if name != "/reset":
            raise NotFound("no service")
        if type_name not in (None, "std_srvs/srv/SetBool"):
            raise InvalidField([FieldError("type", "a type that it has", "got another one", "query")])
        return FoundService(name, "std_srvs/srv/SetBool", ("std_srvs/srv/SetBool",))

    load = staticmethod(ServiceCalls.load)


class Topics:
    """The topic `/light`, which may be published on."""

    def require_allowed(self, name: str) -> None:
        AllowList("allow_publish", ["/light"], "the gateway does not publish on").require(name)

    async def find(self, name: str, _: str | None) -> FoundTopic:
        return FoundTopic(name, "std_msgs/msg/Bool", ("std_msgs/msg/Bool",), latched=False, subscribers=1)

    load = staticmethod(Publishing.load)


class Client(RouteClient):
    """`/missions` of a gateway with the robots `/` and `/robot1`, which nobody carries out."""

    def __init__(self) -> None:
        history = HistoryInMemory()
        self.stopped = False
        self.actions = actions = cast("Any", SimpleNamespace(docking_name=self.docking_name))
        self.book = MissionBook(
            Fanout(queue_limit=1),
            history.documents("mission", MissionEntry),
            history.documents("ended_mission", MissionEntry),
            lambda mission, grant: covers(mission, grant, actions, self.members),
        )
        self.places = Places(SharedBook(history.documents("place", PlaceEntry), "place", MAX_PLACES))
        self.templates = Templates(SharedBook(history.documents("template", TemplateEntry), "template", MAX_TEMPLATES))
        self.missions = Missions(
            self.book,
            cast("Any", SimpleNamespace(wake=lambda: None)),
            robots=cast("Any", SimpleNamespace(get=self.get_robot, default_namespace="/")),
            actions=cast("Any", SimpleNamespace(get=lambda name: self if name == "/fibonacci" else None)),
            robot_actions=actions,
            messages=Messages(cast("Any", Services()), cast("Any", Topics())),
            places=self.places,
            templates=self.templates,
            interlock=cast("Any", self),
            members=self.members,
            approvals=cast("Any", SimpleNamespace(needs=self.needs)),
            last_stops=LastStops(history.documents("mission_stop", LastStop)),
        )
        self.parts = cast("Any", {Missions: self.missions})
        store = history.documents("schedule", ScheduleEntry)
        self.schedules = Schedules(
            SharedBook(store, "schedule", MAX_SCHEDULES, BY_THEMSELVES),
            self.missions,
            cast("Any", SimpleNamespace(get=self.get_robot, find=lambda _: "/")),
        )
        super().__init__(
            {
                Missions: self.missions,
                Templates: self.templates,
                Schedules: self.schedules,
                KnownRobots: make_known_robots(history, "/", "/robot2"),
            }
        )

    def get_robot(self, name: str | None) -> Any:
        """Stand in for the robots."""
        if name == "/nowhere":
            raise NotFound("there is no robot", code="robot_not_found")
        return SimpleNamespace(namespace=name or "/")

    @staticmethod
    def members(group: str) -> set[str]:
        """Stand in for the labels of robots."""
        return {"/robot1", "/robot2"} if group == "pickers" else set()

    def needs(self, grant: Grant, action_name: str) -> bool:
        """Stand in for the approvals: `/robot1` is simulated."""
        return grant.role is Role.AGENT and not action_name.startswith("/robot1/")

    def docking_name(self, verb: str, robot: str) -> str:
        """Stand in for the actions of robots."""
        return f"{robot.rstrip('/')}/{verb}"

    async def read_goal(self, request: dict[str, Any], path: str) -> None:
        """Stand in for the action `/fibonacci`."""
        if "order" not in request:
            raise InvalidField([FieldError(path, "an order", "got none")])

    def require_released(self, robot: str, what: str) -> None:
        """Stand in for the interlock."""
        if self.stopped:
            raise Conflict(f"{robot} was stopped: {what}", code="stop_latched")

    def post(self, body: object = PLAIN, status: int = 201, query: str = "", **headers: str) -> Any:
        return self.send("POST", f"/missions{query}", status, json=body, headers=headers)

    def change(self, mission_id: str, verb: str, status: int = 200) -> Any:
        return self.send("POST", f"/missions/{mission_id}/{verb}", status, template=f"/missions/{{mission_id}}/{verb}")

    def get(self, mission_id: str, status: int = 200) -> Any:
        return self.send("GET", f"/missions/{mission_id}", status, template="/missions/{mission_id}")

    def put(self, mission_id: str, body: object, status: int = 200, **headers: str) -> Any:
        template = "/missions/{mission_id}"
        return self.send("PUT", f"/missions/{mission_id}", status, template=template, json=body, headers=headers)

    def move(self, mission_id: str, status: int = 200, **place: str) -> Any:
        template = "/missions/{mission_id}/move"
        return self.send("POST", f"/missions/{mission_id}/move", status, template=template, json=place)

    def queue(self) -> list[str]:
        """The missions that are queued, in the order in which they begin."""
        found = self.send("GET", "/missions?status=queued")["missions"]
        found.sort(key=lambda each: (-each["priority"], each["order"], each["created_at"]))
        return [each["mission_id"] for each in found]

    def ask(self, robot: str, *steps: dict[str, Any], **fields: Any) -> dict[str, Any]:
        """Queue a mission as an agent does by its tool; return it."""

        async def ask() -> Any:
            tool = next(tool for tool in TOOLS if tool.name == "create_mission")
            arguments = tool.read({"robot": robot, "steps": [*steps], **fields})
            return await tool.command(self.parts, AGENT, arguments)

        assert self.http.portal is not None
        answer: dict[str, Any] = orjson.loads(encode(self.http.portal.call(ask)["mission"]))
        return answer

    def ids(self, query: str = "") -> list[str]:
        return [mission["mission_id"] for mission in self.send("GET", f"/missions{query}")["missions"]]

    def set(self, mission_id: str, **fields: Any) -> None:
        """Let a mission be in another state."""

        async def store() -> None:
            mission = await self.book.find(mission_id)
            assert await self.book.change(mission_id, mission, mission.but(**fields))

        assert self.http.portal is not None
        self.http.portal.call(store)
