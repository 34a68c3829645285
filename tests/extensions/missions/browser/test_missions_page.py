"""Missions by clicking: put together, queued for a group, edited, moved, seen on the day; a stop holds one."""

import re
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Page, Request, Route, expect

from tests.browser.axe import find_violations
from tests.browser.layout import find_layout_faults
from tests.support.docking import FAST, PATIENT, UNMEASURED
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.waiting import wait_until

# A start that is near the dock.
NEAR = ("-p", FAST, "-p", "start_x:=-1.1", "-p", "start_y:=0.1", "-p", "start_theta:=-0.1")
STEADY = ("-p", "controller:=dock_pose", "-p", PATIENT, "-p", UNMEASURED)


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator", *NEAR))
        stack.enter_context(running_program(domain, "docking_server", *STEADY))
        gateway = stack.enter_context(running_gateway(domain))
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        yield gateway


def add(page: Page, step: str) -> None:
    page.get_by_role("button", name=f"Add step: {step}").click()


def expect_fits(page: Page) -> None:
    assert find_violations(page) == []
    assert find_layout_faults(page) == []


def test_a_mission_is_put_together_and_succeeds(page: Page, gateway: RunningGateway) -> None:
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Missions").click()
    expect(page.get_by_text("No missions")).to_be_visible()
    expect_fits(page)
    page.get_by_role("button", name="New mission").click()
    page.get_by_label("Name", exact=True).fill("Round")
    page.get_by_label("Your name").fill("Ada")
    for step in ("Wait", "Undock", "Dock"):
        add(page, step)
    page.get_by_role("button", name="Move step 3 up").press("Enter")
    expect(page.get_by_role("button", name="Move step 2 up")).to_be_focused()
    page.get_by_role("button", name="Move step 2 up").press("Enter")
    steps = page.get_by_role("list", name="Steps").get_by_role("listitem")
    expect(steps).to_have_count(3)
    names = [step.get_attribute("aria-label") for step in steps.all()]
    assert names == ["Step 1: Dock", "Step 2: Wait", "Step 3: Undock"]
    seconds = page.get_by_role("textbox", name="Wait for")
    seconds.fill("700000")
    expect(page.get_by_text("From 0 s to a week")).to_be_visible()
    seconds.fill("1")
    expect_fits(page)
    page.get_by_role("button", name="Start mission").click()

    mission = page.get_by_role("article", name="Round")
    expect(mission).to_contain_text(re.compile("Running.*Began .* by Ada.*Step 1 of 3: Dock", re.DOTALL))
    expect(mission.get_by_role("link", name=re.compile("^Goal "))).to_be_visible()
    expect_fits(page)
    page.get_by_role("link", name="Overview").click()
    expect(page.get_by_role("region", name="Mission", exact=True)).to_contain_text("Round")
    page.get_by_role("link", name="All missions").click()
    row = page.get_by_role("row").filter(has_text="Round")
    expect(row).to_contain_text("Succeeded")
    expect(page.get_by_role("article")).to_have_count(0)
    page.get_by_role("link", name="Round").click()
    expect(page.get_by_role("list", name="Steps").get_by_text(": Done")).to_have_count(3)
    page.get_by_role("button", name="Run again").click()
    expect(steps).to_have_count(3)
    assert gateway.http.get("/missions").json()["missions"][0]["status"] == "succeeded"


def test_a_stop_holds_a_mission_until_somebody_continues_it(page: Page, gateway: RunningGateway) -> None:
    body = {"name": "Held", "steps": [{"wait": {"seconds": 3600}}, {"wait": {"seconds": 0}}]}
    gateway.http.post("/missions", json=body).raise_for_status()
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Missions").click()
    mission = page.get_by_role("article", name="Held")
    expect(mission).to_contain_text("Goes on in")
    gateway.http.post("/stop").raise_for_status()
    expect(mission).to_contain_text("The mission does not go on by itself")
    proceed = page.get_by_role("button", name="Continue: Held")
    expect(proceed).to_have_attribute("aria-disabled", "true")
    assert find_violations(page) == []
    gateway.http.delete("/stop").raise_for_status()
    expect(proceed).not_to_have_attribute("aria-disabled", "true")
    expect(mission).to_contain_text("Held")
    proceed.click()
    expect(mission).to_contain_text("Running")
    page.get_by_role("button", name="Pause: Held").click()
    expect(mission).to_contain_text("It pauses after this step")
    page.get_by_role("button", name="Cancel: Held").click()
    expect(page.get_by_role("row").filter(has_text="Held")).to_contain_text("Canceled")
    expect(mission).to_have_count(0)


@pytest.mark.expect_page_errors
def test_what_the_gateway_refuses_is_shown_at_its_field(page: Page, gateway: RunningGateway) -> None:
    page.goto(f"{gateway.url}/ui/missions/new?example=charge")
    battery = page.get_by_role("textbox", name="Until the battery has")
    expect(battery).to_have_value("80 %")

    def spoil(route: Route, request: Request) -> None:
        body = request.post_data
        route.continue_(post_data=None if body is None else body.replace('"battery":0.8', '"battery":1.8'))

    page.route("**/missions?*", spoil)
    page.get_by_role("button", name="Start mission").click()
    expect(battery).to_have_attribute("aria-invalid", "true")
    card = page.get_by_role("listitem", name="Step 2: Wait")
    expect(card).to_contain_text("expected")
    assert find_violations(page) == []
    battery.fill("90")
    expect(battery).not_to_have_attribute("aria-invalid", "true")
    statuses = [each["status"] for each in gateway.http.get("/missions").json()["missions"]]
    assert "queued" not in statuses
    assert "running" not in statuses


@pytest.mark.expect_page_errors
def test_a_queue_is_moved_and_its_missions_are_edited(page: Page, gateway: RunningGateway) -> None:
    def queue(name: str) -> str:
        body = {"name": name, "steps": [{"wait": {"seconds": 3600}}]}
        return gateway.http.post("/missions", json=body).raise_for_status().json()["mission_id"]

    ids = [queue(name) for name in ("Now", "One", "Two")]
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Missions").click()
    rows = page.get_by_role("list", name=re.compile("^Next for ")).get_by_role("listitem")
    expect(rows).to_have_count(2)
    expect_fits(page)
    page.get_by_role("button", name="Move Two up").press("Enter")
    expect(rows.first).to_contain_text("Two")
    expect(rows.first).to_be_focused()
    page.get_by_role("button", name="Move Two down").press("Enter")
    expect(rows.first).to_contain_text("One")
    page.get_by_role("link", name="Edit: Two").click()
    name = page.get_by_role("textbox", name="Name", exact=True)
    expect(name).to_have_value("Two")
    name.fill("Mine")
    theirs = {"name": "Theirs", "steps": [{"wait": {"seconds": 60}}]}
    gateway.http.put(f"/missions/{ids[2]}", json=theirs).raise_for_status()
    page.get_by_role("button", name="Save").click()
    expect(page.get_by_text("Someone else has changed it meanwhile")).to_be_visible()
    expect_fits(page)
    page.get_by_role("button", name="Replace it with mine").click()
    expect(rows.last).to_contain_text("Mine")
    for mission_id in ids:
        gateway.http.post(f"/missions/{mission_id}/cancel").raise_for_status()
    expect(page.get_by_role("article")).to_have_count(0)


def test_a_mission_for_a_group_is_taken_by_its_robot(page: Page, gateway: RunningGateway) -> None:
    robot = gateway.http.get("/robots").json()["robots"][0]["name"]
    label = {"display_name": None, "groups": ["pickers"]}
    gateway.http.put("/label", params={"robot": robot}, json=label).raise_for_status()
    page.goto(f"{gateway.url}/ui/missions/new")
    page.get_by_label("For", exact=True).select_option("Any of pickers")
    page.get_by_label("Name", exact=True).fill("Grouped")
    add(page, "Wait")
    page.get_by_role("textbox", name="Wait for").fill("0")
    expect_fits(page)
    page.get_by_role("button", name="Start mission").click()
    expect(page.get_by_role("row").filter(has_text="Grouped")).to_contain_text("Succeeded")
    mission = gateway.http.get("/missions").json()["missions"][0]
    assert (mission["group"], mission["robot"]) == ("pickers", robot)


def test_the_missions_of_today_lead_to_their_pages(page: Page, gateway: RunningGateway) -> None:
    def queue(name: str, seconds: float) -> str:
        body = {"name": name, "steps": [{"wait": {"seconds": seconds}}]}
        return gateway.http.post("/missions", json=body).raise_for_status().json()["mission_id"]

    queue("Over", 0)
    running = queue("Under way", 3600)
    page.goto(f"{gateway.url}/ui/missions/today")
    bar = page.get_by_role("link", name=re.compile("^Under way, .* now. Running. Step 1 of 1: Wait"))
    page.get_by_text("1 hour", exact=True).click()
    expect(bar).to_be_visible()
    page.mouse.move(0, 0)
    expect_fits(page)
    page.set_viewport_size({"width": 390, "height": 900})
    expect(page.get_by_role("listitem").filter(has_text="Under way").last).to_contain_text("now")
    expect(page.get_by_role("listitem").filter(has_text="Over").last).to_contain_text("Succeeded")
    assert find_violations(page) == []
    page.set_viewport_size({"width": 1440, "height": 1000})
    bar.click()
    expect(page.get_by_role("heading", name="Under way")).to_be_visible()
    gateway.http.post(f"/missions/{running}/cancel").raise_for_status()
    expect(page.get_by_role("article")).to_contain_text("Canceled")


def test_a_robot_charges_and_goes_on(page: Page, gateway: RunningGateway) -> None:
    gateway.http.post("/simulator/reset").raise_for_status()
    page.goto(f"{gateway.url}/ui/missions/new")
    page.get_by_label("Name", exact=True).fill("Charged")
    add(page, "Wait")
    page.get_by_role("checkbox", name="Return to charge").check()
    charge = page.get_by_role("textbox", name="Charges to")
    charge.fill("20")
    expect(page.get_by_text("From 30 to 100 %")).to_be_visible()
    charge.fill("90")
    expect_fits(page)
    page.get_by_role("button", name="Start mission").click()
    mission = page.get_by_role("article", name="Charged")
    expect(mission).to_contain_text(re.compile("Returns below 25.%, charges to 90.%"))
    expect(mission).to_contain_text("Then Step 1 of 1: Wait")
    expect(mission).to_contain_text(re.compile("Charging.*the mission goes on at 90.%", re.DOTALL))
    expect_fits(page)
    page.get_by_role("button", name="Cancel: Charged").click()
    expect(page.get_by_role("row").filter(has_text="Charged")).to_contain_text("Canceled")
