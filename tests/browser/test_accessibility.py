"""WCAG 2.2 AA on the dashboard, in both colour schemes."""

import pytest
from playwright.sync_api import Page, expect

from tests.browser.axe import find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import LOW, RunningGateway


@pytest.fixture
def page(page: Page) -> Page:
    """The dashboard, live."""
    expect(page.get_by_test_id("connection")).to_have_text("live")
    return page


def dock(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    page.get_by_role("button", name="Dock", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Dock", exact=True).click()
    expect(page.get_by_test_id("goal-status")).to_have_text("executing")
    expect(page.get_by_text("turning left")).to_be_visible()


def test_the_idle_page(page: Page) -> None:
    assert find_violations(page) == []


def test_the_developer_tab(page: Page) -> None:
    page.get_by_role("tab", name="Developer").click()
    expect(page.get_by_role("heading", name="From a terminal")).to_be_visible()
    assert find_violations(page) == []


def test_a_running_goal(page: Page, gateway: RunningGateway) -> None:
    dock(page, gateway)
    assert find_violations(page) == []


@pytest.mark.parametrize("width", [320, 820])
def test_a_narrow_window(page: Page, gateway: RunningGateway, width: int) -> None:
    """At 320 CSS pixels nothing is cut off or scrolled sideways (WCAG 1.4.10)."""
    page.set_viewport_size({"width": width, "height": 1000})
    dock(page, gateway)
    assert find_violations(page) == []
    expect_no_sideways_scrolling(page)


def test_the_help(page: Page) -> None:
    page.get_by_role("link", name="Help: Docking", exact=True).click()
    expect(page.get_by_role("heading", name="What the dock server does")).to_be_focused()
    assert find_violations(page) == []
    page.set_viewport_size({"width": 320, "height": 1000})
    expect_no_sideways_scrolling(page)
