"""WCAG 2.2 AA on the dashboard as a browser draws it, by axe: contrast and sizes too, which jsdom cannot tell."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.support.gateway import LOW, RunningGateway

AXE = Path(__file__).parents[2] / "frontend/node_modules/axe-core/axe.min.js"
SETTLED = "Promise.allSettled(document.getAnimations().map((animation) => animation.finished))"
RUN = """async () => {
    const tags = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"];
    const rules = {"target-size": {enabled: true}};
    const {violations, passes} = await axe.run(document, {runOnly: {type: "tag", values: tags}, rules});
    return {
        found: violations.flatMap(({id, nodes}) => nodes.map((node) => [id, node.html, node.failureSummary])),
        passed: passes.map(({id}) => id),
    };
}"""


@pytest.fixture(params=["light", "dark"])
def page(page: Page, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The dashboard, live, in one colour scheme, with axe in it."""
    if not AXE.exists():
        pytest.fail(f"{AXE} is missing: run npm ci in frontend/")
    page.emulate_media(color_scheme=request.param, reduced_motion="reduce")
    expect(page.locator("html")).to_have_attribute("data-mantine-color-scheme", request.param)
    expect(page.get_by_test_id("connection")).to_have_text("live")
    page.evaluate(AXE.read_text(encoding="utf-8"))
    return page


def run_axe(page: Page) -> dict[str, Any]:
    # Half way through a transition the colours are neither the old ones nor the new ones.
    page.evaluate(SETTLED)
    report: dict[str, Any] = page.evaluate(RUN)
    assert {"color-contrast", "target-size", "button-name"} <= set(report["passed"])
    return report


def dock(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    page.get_by_role("button", name="Dock", exact=True).click()
    expect(page.get_by_test_id("goal-status")).to_have_text("executing")
    expect(page.get_by_text("turning left")).to_be_visible()


def test_the_idle_page(page: Page) -> None:
    assert run_axe(page)["found"] == []


def test_a_running_goal(page: Page, gateway: RunningGateway) -> None:
    dock(page, gateway)
    assert run_axe(page)["found"] == []


def test_the_details_of_a_goal(page: Page, gateway: RunningGateway) -> None:
    dock(page, gateway)
    page.get_by_role("table").filter(has_text="Origin").get_by_role("button").first.click()
    expect(page.get_by_role("dialog", name="Goal")).to_be_visible()
    assert run_axe(page)["found"] == []


@pytest.mark.parametrize("width", [320, 820])
def test_a_narrow_window(page: Page, gateway: RunningGateway, width: int) -> None:
    """At 320 CSS pixels nothing is cut off or scrolled sideways (WCAG 1.4.10)."""
    page.set_viewport_size({"width": width, "height": 1000})
    dock(page, gateway)
    assert run_axe(page)["found"] == []
    assert page.evaluate("document.documentElement.scrollWidth") == width
