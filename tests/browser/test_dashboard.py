"""The dashboard by clicking, as its users do."""

import re
import signal

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from tests.support.domain import ros_domain
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_dock_server, running_gateway


def press(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def dock(page: Page) -> None:
    """Dock a robot that is real as far as the page knows: it asks."""
    press(page, "Dock")
    page.get_by_role("dialog", name="Dock the robot?").get_by_role("button", name="Dock", exact=True).click()


def publish(page: Page, preset: str) -> None:
    """Publish in the Developer tab, and come back."""
    page.get_by_role("tab", name="Developer").click()
    page.get_by_text(preset, exact=True).first.click()
    press(page, "Publish repeatedly")
    page.get_by_role("tab", name="Operate").click()


def expect_status(page: Page, status: str) -> None:
    expect(page.get_by_test_id("goal-status")).to_have_text(status, ignore_case=True)


def test_the_tutorial_by_clicking(page: Page) -> None:
    expect(page.get_by_test_id("connection")).to_contain_text("live", ignore_case=True)
    publish(page, "Low battery, not charging")
    expect(page.get_by_test_id("battery-status")).to_contain_text("not charging", ignore_case=True)
    dock(page)
    expect_status(page, "executing")
    expect(page.get_by_text("24 %").first).to_be_visible()
    publish(page, "On the dock, charging")
    expect_status(page, "succeeded")
    page.get_by_role("tab", name="Developer").click()
    press(page, "Stop publishing")
    expect(page.get_by_test_id("publisher-status")).to_contain_text("Not publishing")


def test_cancel_by_clicking(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    dock(page)
    expect_status(page, "executing")
    press(page, "Cancel")
    expect_status(page, "canceled")


def test_stop_by_clicking(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    dock(page)
    expect_status(page, "executing")
    page.get_by_role("button", name="Stop", exact=True).click()
    expect_status(page, "canceled")


def test_a_goal_sent_by_someone_else_is_seen(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    goal_id = gateway.http.post("/dock").json()["goal_id"]
    expect_status(page, "executing")
    gateway.publish(CHARGING)
    gateway.wait_for_goal(goal_id, "succeeded")
    expect_status(page, "succeeded")


@pytest.mark.expect_page_errors
def test_the_page_says_when_the_gateway_is_gone_and_goes_on_when_it_is_back(browser: Browser) -> None:
    with ros_domain() as domain, running_dock_server(domain):
        with running_gateway(domain) as first:
            first.wait_until_ready()
            port = first.url.rpartition(":")[2]
            page = browser.new_page(reduced_motion="reduce")
            page.goto(first.url)
            expect(page.get_by_test_id("connection")).to_contain_text("live", ignore_case=True)
            dock(page)
            expect_status(page, "executing")
            press(page, "Cancel")
            expect_status(page, "canceled")
            first.process.send_signal(signal.SIGTERM)
            first.process.wait()
            expect(page.get_by_test_id("connection")).not_to_contain_text("live", ignore_case=True)
        with running_gateway(domain, port=port):
            expect(page.get_by_test_id("connection")).to_contain_text("live", ignore_case=True)
        page.close()


def test_the_api_pages_need_no_internet(page: Page, gateway: RunningGateway) -> None:
    page.goto(f"{gateway.url}/docs")
    search = page.get_by_placeholder("Filter")  # what is further down is drawn once one scrolls there
    search.fill("/battery/publisher")
    expect(page.get_by_text("/battery/publisher").first).to_be_visible()
    search.fill("/healthz")
    health = page.locator(".opblock", has_text="/healthz")
    health.locator(".opblock-summary").click()
    health.get_by_role("button", name="Execute").click()
    expect(health.locator(".live-responses-table")).to_contain_text('"status": "ok"')


@pytest.mark.expect_page_errors
def test_a_part_of_the_page_that_cannot_be_loaded_is_loaded_later(page: Page, gateway: RunningGateway) -> None:
    page.route("**/assets/GoalsPage-*", lambda route: route.abort())
    page.route("**/healthz", lambda route: route.abort())
    page.get_by_role("link", name=re.compile("^Goals")).click()
    expect(page).to_have_url(re.compile("/ui/goals"))
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_test_id("stop-banner")).to_be_visible()
    page.unroute("**/assets/GoalsPage-*")
    page.unroute("**/healthz")
    expect(page.get_by_role("heading", level=1, name="Goals")).to_be_visible()


@pytest.mark.expect_page_errors
def test_a_page_whose_gateway_leaves_while_a_part_is_loaded_is_loaded_again(page: Page) -> None:
    there = True

    def answer(route: Route) -> None:
        route.continue_() if there else route.abort()

    def leave(route: Route) -> None:
        nonlocal there
        there = False
        route.abort()

    page.route("**/healthz", answer)
    page.route("**/assets/GoalsPage-*", leave)
    with page.expect_event("requestfailed", lambda request: "healthz" in request.url):
        page.get_by_role("link", name=re.compile("^Goals")).click()
    page.unroute("**/assets/GoalsPage-*")
    there = True
    expect(page.get_by_role("heading", level=1, name="Goals")).to_be_visible()


@pytest.mark.expect_page_errors
def test_a_page_of_another_version_is_loaded_anew(page: Page, gateway: RunningGateway) -> None:
    """After an update of the gateway, an open page asks for files that are no longer there."""
    page.route("**/assets/GoalsPage-*", lambda route: route.fulfill(status=404))
    page.get_by_role("link", name=re.compile("^Goals")).click()
    expect(page.get_by_role("alert")).to_contain_text("This page cannot be shown")
    page.get_by_role("button", name="Stop", exact=True).click()
    expect(page.get_by_test_id("stop-banner")).to_be_visible()
    page.get_by_role("link", name=re.compile("^Overview")).click()
    expect(page.get_by_role("button", name="Dock", exact=True)).to_be_visible()
    page.get_by_role("link", name=re.compile("^Goals")).click()
    page.unroute_all()
    page.get_by_role("button", name="Load it again").click()
    expect(page.get_by_role("heading", level=1, name="Goals")).to_be_visible()
