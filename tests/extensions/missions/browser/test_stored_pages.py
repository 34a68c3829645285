"""Places, templates and schedules by clicking: stored, run, switched off and removed."""

import re
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Page, expect

from tests.browser.axe import find_violations
from tests.browser.layout import find_layout_faults
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.docking import FAST
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.waiting import wait_until


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator", "-p", FAST, "-p", "start_x:=-1.5"))
        gateway = stack.enter_context(running_gateway(domain))
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        yield gateway


def expect_fits(page: Page) -> None:
    assert find_violations(page) == []
    assert find_layout_faults(page) == []


def open_page(page: Page, gateway: RunningGateway, name: str) -> None:
    page.goto(f"{gateway.url}/ui/missions")
    page.get_by_role("navigation", name="Missions").get_by_role("link", name=name).click()


def test_a_place_is_where_the_robot_stands(page: Page, gateway: RunningGateway) -> None:
    open_page(page, gateway, "Places")
    expect(page.get_by_text("No places")).to_be_visible()
    expect_fits(page)
    page.get_by_role("button", name="New place").click()
    page.get_by_label("Name", exact=True).fill("Shelf A3")
    page.get_by_role("button", name="stands now").click()
    expect(page.get_by_role("textbox", name="X")).to_have_value("-1.5 m")
    page.get_by_label("Your name").fill("Ada")
    expect_fits(page)
    page.get_by_role("button", name="Save").click()
    card = page.get_by_role("listitem", name="Shelf A3")
    expect(card).to_contain_text("x -1.5 m")
    expect(card).to_contain_text("shelf-a3")
    expect_fits(page)
    place = gateway.http.get("/places/shelf-a3").json()
    assert (place["x"], place["frame"], place["changed_by"]) == (-1.5, "map", "Ada")
    page.get_by_role("button", name="Remove Shelf A3").click()
    page.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_text("No places")).to_be_visible()


def test_a_mission_is_saved_as_a_template_and_run(page: Page, gateway: RunningGateway) -> None:
    page.goto(f"{gateway.url}/ui/missions/new")
    page.get_by_role("button", name="Add step: Wait").click()
    page.get_by_role("button", name="Save as template").click()
    page.get_by_label("Name", exact=True).fill("Rest")
    expect(page.get_by_role("textbox", name="Wait for")).to_have_value("60 s")
    page.get_by_role("button", name="Write as JSON").click()
    step = page.get_by_role("textbox", name="Step", exact=True)
    step.fill(step.input_value().replace('"seconds": 60', '"seconds": "$seconds"'))
    page.get_by_role("textbox", name="What seconds is").fill("How long")
    page.set_viewport_size({"width": 1440, "height": 1800})  # all of it is in sight
    expect_fits(page)
    page.get_by_role("button", name="Save").click()
    card = page.get_by_role("listitem", name="Rest")
    expect(card).to_contain_text("Parameters: seconds")
    expect_fits(page)
    page.get_by_role("button", name="Run Rest").click()
    page.get_by_role("button", name="Start mission").click()
    expect(page.get_by_text("Needs a value.")).to_be_visible()
    page.get_by_role("textbox", name="seconds").fill("0")
    page.get_by_role("button", name="Start mission").click()
    expect(page.get_by_role("row").filter(has_text="Rest")).to_contain_text("Succeeded")
    assert gateway.http.get("/missions").json()["missions"][0]["template"] == "rest"


def test_a_schedule_is_stored_and_switched_off(page: Page, gateway: RunningGateway) -> None:
    template = {"parameters": {"seconds": {"default": 0}}, "steps": [{"wait": {"seconds": "$seconds"}}]}
    gateway.http.put("/mission-templates/rest", json=template).raise_for_status()
    open_page(page, gateway, "Schedules")
    expect(page.get_by_text("No schedules")).to_be_visible()
    page.get_by_role("button", name="New schedule").click()
    page.get_by_label("Name", exact=True).fill("Night")
    expect(page.get_by_label("Mission", exact=True)).to_have_value("rest")
    page.get_by_label("Mission", exact=True).select_option("Steps, put together here")
    names = [
        step.get_attribute("aria-label")
        for step in page.get_by_role("list", name="Steps").get_by_role("listitem").all()
    ]
    assert names == ["Step 1: Undock", "Step 2: Dock"]
    expect(page.get_by_role("button", name="Move step 2 up")).to_be_visible()
    page.get_by_label("Mission", exact=True).select_option("rest")
    page.get_by_text("Every …").click()
    expect(page.get_by_role("textbox", name="Every")).to_have_value("60 min")
    page.get_by_text("Times of day", exact=True).click()
    page.set_viewport_size({"width": 1440, "height": 1400})  # all of it is in sight
    assert find_violations(page) == []
    page.set_viewport_size({"width": 390, "height": 900})
    expect_no_sideways_scrolling(page)
    page.set_viewport_size({"width": 1440, "height": 1000})
    page.get_by_role("button", name="Save").click()
    card = page.get_by_role("listitem", name="Night")
    expect(card).to_contain_text(re.compile("Every day at 22:00"))
    expect(card).to_contain_text("Next")
    expect_fits(page)
    page.get_by_role("switch", name="Night is on").click()
    expect(card).to_contain_text("Switched off")
    assert gateway.http.get("/schedules/night").json()["enabled"] is False
