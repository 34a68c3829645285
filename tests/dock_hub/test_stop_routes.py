"""`/stop` of a hub."""

import asyncio
import json
from collections.abc import Iterator
from contextlib import asynccontextmanager
from types import SimpleNamespace
from typing import Any

import pytest
from fastapi.testclient import TestClient
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.access.logins import Logins
from dock_gateway.application import Contents, build_app
from dock_gateway.audit.record import RequestRecord
from dock_gateway.client.documents import StopReport
from dock_gateway.core.grant import Grant, Role
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.robots.robots import Robots
from dock_gateway.settings import Settings
from dock_hub import stop_routes
from dock_hub.overview import Overview
from dock_hub.stops import Stops
from tests.dock_hub.stopped_sites import BERLIN, OSLO, TIMES, Answer, FakeSite, FakeSites, Store
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory


class Hub:
    """A hub with two sites, and nothing else."""

    def __init__(self, **how: Any) -> None:
        settings = Settings(**{"database_url": "memory:", **how})
        self.reach = FakeSites(BERLIN, OSLO)
        self.logins = Logins(HistoryInMemory())
        self.parts = Parts({**audit_parts(), Settings: settings, Logins: self.logins, Quotas: Quotas(settings)})
        app = build_app(settings, (stop_routes.router,), self._open, Contents("A hub."))
        self.http = TestClient(app, "http://127.0.0.1:8000")

    @asynccontextmanager
    async def _open(self) -> Any:
        stops = Stops(self.reach, Store(), TIMES)
        stops.open()
        self.parts.add(Stops, stops)
        names = [f"/{site}{robot}" for site in self.reach.names() for robot in self.site(site).robots]
        robots = SimpleNamespace(default_namespace="/", namespaces=lambda: names)
        self.parts.add(Robots, robots)  # type: ignore[arg-type]
        self.parts.add(Overview, robots)  # type: ignore[arg-type]
        yield self.parts
        await stops.close()

    def site(self, name: str) -> FakeSite:
        return self.reach.sites[name]


@pytest.fixture
def hub() -> Iterator[Hub]:
    hub = Hub()
    with hub.http:
        yield hub


def test_all_sites_are_stopped_and_released(hub: Hub) -> None:
    answer = hub.http.post("/stop", json={"by": "Ada"})
    assert answer.status_code == 200
    assert {name: site["stopped"] for name, site in answer.json()["sites"].items()} == {BERLIN: True, OSLO: True}
    assert hub.site(BERLIN).latched
    report = StopReport.read(answer.json())  # a client of gateways can read it
    assert (report.canceling, report.unconfirmed) == (["a", "a"], ["/berlin/robot1/dock", "/oslo/robot1/dock"])
    assert (report.stop["by"], len(report.stop["robots"])) == ("Ada", 4)
    assert report.stopped == ["/berlin/robot1", "/berlin/robot2", "/oslo/robot1", "/oslo/robot2"]
    assert report.stop["latched"]
    assert hub.http.get("/stop").json() == report.stop
    one = hub.http.get("/stop", params={"robot": "/berlin/robot1"}).json()
    assert (one["latched"], one["robots"]) == (True, ["/berlin/robot1", "/berlin/robot2"])
    hub.site(OSLO).stopped_at = "2026-11-30T11:00:00Z"
    released = hub.http.delete("/stop")
    assert released.status_code == 200
    sites = {name: {"released": True, "code": None, "detail": None} for name in (BERLIN, OSLO)}
    state = {"latched": False, "for_all": False, "stopped_at": None, "by": None}
    state |= {"robots": [], "stops": [], "persisted": True}
    assert released.json() == state | {"sites": sites}
    assert not hub.site(OSLO).latched
    again = hub.http.post("/stop", json={"by": "Bob"}).json()["stop"]
    assert (again["stopped_at"], again["by"]) == ("2026-11-30T11:00:00Z", "Bob")


def test_a_stop_that_is_not_confirmed_is_no_success(hub: Hub) -> None:
    hub.site(OSLO).reachable = False
    answer = hub.http.post("/stop")
    problem = answer.json()
    assert (answer.status_code, problem["code"]) == (504, "stop_incomplete")
    assert problem["sites"][BERLIN]["stopped"]
    away = {"code": "site_unreachable", "detail": "the site oslo is not connected"}
    assert problem["sites"][OSLO] == {"stopped": False, "warning": None, "repeated": True, **away}
    assert (problem["stopped"], problem["not_stopped"]) == (
        ["/berlin/robot1", "/berlin/robot2"],
        ["/oslo/robot1", "/oslo/robot2"],
    )
    assert problem["failed"] == [{"action_name": None, "robot": "/oslo", **away}]
    assert (problem["canceling"], problem["stop"]["latched"], problem["stop"]["for_all"]) == (["a"], True, False)
    assert "1 of 2 sites (oslo: the site oslo is not connected)" in problem["detail"]
    released = hub.http.delete("/stop")
    assert (released.status_code, released.json()["code"]) == (504, "release_incomplete")
    assert {name: site["released"] for name, site in released.json()["sites"].items()} == {BERLIN: True, OSLO: False}


def test_a_site_that_does_not_answer_does_not_count_as_stopped(hub: Hub) -> None:
    assert hub.http.post("/stop").status_code == 200
    hub.site(OSLO).reachable = False
    state = hub.http.get("/stop").json()
    assert (state["latched"], state["for_all"]) == (True, False)
    assert state["robots"] == [stop["robot"] for stop in state["stops"]] == ["/berlin/robot1", "/berlin/robot2"]
    away = hub.http.get("/stop", params={"robot": "/oslo/robot1"})
    assert (away.status_code, away.json()["code"]) == (503, "site_unreachable")
    unknown = hub.http.get("/stop", params={"robot": "/paris"})
    assert (unknown.status_code, unknown.json()["code"]) == (404, "site_not_found")


def test_what_the_sites_report_besides_is_in_the_report_of_all(hub: Hub) -> None:
    warning = {"code": "stop_not_persisted", "detail": "the disk is full", "status": 503}
    berlin = hub.site(BERLIN)
    berlin.warning, berlin.others = warning, [{"host": "b", "address": None, "robots": ["/fleet_b/*"]}]
    hub.site(OSLO).others = [{"host": "o", "address": "http://o:8000", "robots": []}]
    unknown = {"action_name": None, "robot": "/robot9", "code": "robot_not_found", "detail": "no robot /robot9"}
    berlin.failed = [unknown]
    report = hub.http.post("/stop", headers={"Prefer": "wait=2"}).json()
    assert (report["warning"]["code"], report["stop"]["persisted"]) == ("stop_not_persisted", False)
    assert report["warning"]["detail"] == report["sites"][BERLIN]["warning"] == "berlin: the disk is full"
    assert [(each["host"], each["robots"]) for each in report["others"]] == [
        ("b", ["/berlin/fleet_b/*"]),
        ("o", ["/oslo", "/oslo/*"]),
    ]
    assert report["failed"] == [unknown | {"robot": "/berlin/robot9"}]
    assert berlin.waits == [b"wait=2"]
    hub.http.post("/stop", headers={"Prefer": "wait=200"})
    assert berlin.waits[1:] == [b"wait=3"]  # the answer is to be here within 5 s


def test_robots_that_are_not_meant_are_not_stopped(hub: Hub) -> None:
    report = hub.http.post("/stop", params={"robot": "/berlin"}).json()
    assert (len(report["stopped"]), report["not_stopped"]) == (2, ["/oslo/robot1", "/oslo/robot2"])


def test_a_preference_that_is_none_is_a_warning(hub: Hub) -> None:
    answer = hub.http.post("/stop", headers={"Prefer": "wait=soon"})
    assert (answer.status_code, answer.json()["warning"]["errors"][0]["in"]) == (200, "header")
    assert hub.site(BERLIN).latched


def test_the_release_of_one_site_fails_as_it_does_there(hub: Hub) -> None:
    hub.http.post("/stop")
    hub.site(BERLIN).refusal = Answer(409, b'{"code": "stop_latched", "detail": "a stop of /hall holds for it"}')
    one = hub.http.delete("/stop", params={"robot": "/berlin/robot1"})
    assert (one.status_code, one.json()["code"]) == (409, "stop_latched")
    all_of_them = hub.http.delete("/stop")
    assert (all_of_them.status_code, all_of_them.json()["code"]) == (504, "release_incomplete")
    assert all_of_them.json()["sites"][BERLIN] == {
        "released": False,
        "code": "stop_latched",
        "detail": "a stop of /hall holds for it",
    }
    for nonsense in (b"[]", b"{}"):
        hub.site(BERLIN).refusal = Answer(200, nonsense)
        failed = hub.http.delete("/stop", params={"robot": "/berlin"})
        assert (failed.status_code, failed.json()["code"]) == (502, "site_failed")


def test_robots_of_sites_are_stopped(hub: Hub) -> None:
    answer = hub.http.post("/stop", params={"robot": ["/berlin/robot1", "oslo"]})
    assert answer.status_code == 200
    assert hub.site(BERLIN).asked == [("POST", ("/robot1",))]
    assert hub.site(OSLO).asked == [("POST", ("/",))]
    assert hub.http.delete("/stop", params={"robot": "/berlin/robot1"}).status_code == 200
    assert hub.site(BERLIN).asked[1:] == [("DELETE", ("/robot1",))]


def test_an_unknown_site_keeps_none_from_being_stopped(hub: Hub) -> None:
    answer = hub.http.post("/stop", params={"robot": ["/berlin", "/paris/robot1"]})
    assert (answer.status_code, answer.json()["sites"]["paris"]["code"]) == (504, "site_not_found")
    assert hub.site(BERLIN).latched
    hub.site(BERLIN).latched = False
    answer = hub.http.post("/stop", params={"robot": "/paris"})  # it may be misspelt
    warning = answer.json()["warning"]
    assert (answer.status_code, warning["code"]) == (200, "site_not_found")
    assert warning["detail"] == "there is no site paris: all sites are asked to stop"
    assert [entry.robot for entry in hub.parts[RequestRecord].entries] == ["/berlin,/paris/robot1", "/"]  # type: ignore[attr-defined]
    assert hub.site(BERLIN).latched
    assert hub.site(OSLO).latched
    assert hub.http.delete("/stop", params={"robot": "/paris"}).json()["code"] == "site_not_found"


def test_a_malformed_request_still_stops(hub: Hub) -> None:
    answer = hub.http.post("/stop", content=b"{", headers={"Content-Type": "application/json"})
    assert (answer.status_code, answer.json()["warning"]["code"]) == (200, "malformed_json")
    assert hub.site(BERLIN).latched


@pytest.mark.parametrize("role", [Role.VIEWER, Role.SUPERVISOR])
def test_everyone_may_stop_every_robot_and_release_what_is_theirs(role: Role) -> None:
    hub = Hub(authentication=True, database_url="sqlite:////nowhere")
    _, secret = asyncio.run(hub.logins.create_token("ada", Grant(role, robots=("/berlin",))))
    with hub.http:
        assert hub.http.post("/stop").status_code == 401
        hub.http.headers["Authorization"] = f"Bearer {secret}"
        assert hub.http.post("/stop").status_code == 200
        assert hub.site(OSLO).who == [("ada", Grant(Role.VIEWER))]
        wrong = {hub.http.delete("/stop", params=query).json()["code"] for query in ({}, {"robot": "/oslo/robot1"})}
        mine = hub.http.delete("/stop", params={"robot": "/berlin/robot1"})
    if role is Role.VIEWER:
        assert (wrong, mine.status_code) == ({"role_required"}, 403)
    else:
        assert (wrong, mine.status_code) == ({"not_allowed"}, 200)
        assert hub.site(BERLIN).who[1:] == [("ada", Grant(role, robots=("*",)))]


@pytest.mark.parametrize("reachable", [True, False])
def test_an_answer_names_the_robots_of_the_user(reachable: bool) -> None:
    """What is stopped does not depend on it, nor which sites have confirmed it."""
    hub = Hub(authentication=True, database_url="sqlite:////nowhere")
    hub.site(OSLO).reachable = reachable
    hub.site(BERLIN).moving = ["/robot3", "/robot4"]
    grant = Grant(Role.VIEWER, robots=("/berlin/robot1", "/berlin/robot3"))
    _, secret = asyncio.run(hub.logins.create_token("ada", grant))
    with hub.http:
        answer = hub.http.post("/stop", headers={"Authorization": f"Bearer {secret}"})
    document = answer.json()
    assert answer.status_code == (200 if reachable else 504)
    assert {name: site["stopped"] for name, site in document["sites"].items()} == {BERLIN: True, OSLO: reachable}
    assert (document["stopped"], document["not_stopped"]) == (["/berlin/robot1"], ["/berlin/robot3"])


names = st.one_of(
    st.sampled_from(["/berlin", "/berlin/robot1", "berlin/robot2", "/oslo/", "/", "", "/nowhere/robot1", "/berlin//x"]),
    st.text(max_size=8),
)
anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | names,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
orders = st.fixed_dictionaries(
    {}, optional={"robot": names | st.lists(names | anything, max_size=3) | anything, "by": anything, "more": anything}
)
bodies = st.one_of(orders.map(json.dumps).map(str.encode), anything.map(json.dumps).map(str.encode), st.binary())


def test_whatever_a_request_says_it_stops_the_sites_that_it_can_mean(hub: Hub) -> None:
    """All sites, unless each name is clear. No request is refused instead."""

    @settings(max_examples=150, deadline=None)
    @given(bodies, st.lists(names, max_size=2), st.sampled_from(["application/json", "text/plain", "", "x" * 50]))
    def stops(body: bytes, query: list[str], media_type: str) -> None:
        for name in (BERLIN, OSLO):
            hub.site(name).latched = False
        headers = {"Content-Type": media_type} if media_type else {}
        answer = hub.http.post("/stop", params={"robot": query}, content=body, headers=headers)
        assert answer.status_code in {200, 504}, answer.text
        stopped = {name for name in (BERLIN, OSLO) if hub.site(name).latched}
        sites = answer.json()["sites"]
        assert {name for name, site in sites.items() if site["stopped"]} == stopped
        if answer.status_code == 504:  # one that is not there
            assert all(site["code"] == "site_not_found" for site in sites.values() if not site["stopped"])
        try:
            said = json.loads(body) if media_type in {"application/json", ""} else None
        except ValueError:
            said = None
        robot = said.get("robot") if isinstance(said, dict) else None
        named = [*query, *(robot if isinstance(robot, list) else [robot])]
        firsts = {each.strip().strip("/").split("/")[0] for each in named if isinstance(each, str) and each.strip()}
        assert firsts & {BERLIN, OSLO} <= stopped  # who is named is stopped, whatever else it says
        if not firsts & {BERLIN, OSLO}:
            assert stopped == {BERLIN, OSLO}

    stops()


def test_more_robots_than_a_query_has_room_for_are_all_of_the_site(hub: Hub) -> None:
    robots = [f"/{BERLIN}/{'long_' * 30}{number}" for number in range(900)]
    answer = hub.http.post("/stop", json={"robot": robots})
    assert answer.status_code == 200
    assert hub.site(BERLIN).asked == [("POST", ("/",))]
