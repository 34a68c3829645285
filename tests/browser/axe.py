"""WCAG 2.2 AA on a page as a browser draws it, by axe: contrast and sizes too, which jsdom cannot tell."""

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

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


def load_axe(page: Page, scheme: str) -> None:
    """Show the live dashboard in one colour scheme, with axe in it."""
    if not AXE.exists():
        pytest.fail(f"{AXE} is missing: run npm ci in frontend/")
    page.emulate_media(color_scheme="dark" if scheme == "dark" else "light", reduced_motion="reduce")
    expect(page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)
    expect(page.get_by_test_id("connection")).to_have_text("live")
    page.evaluate(AXE.read_text(encoding="utf-8"))


def find_violations(page: Page, *, buttons: bool = True) -> list[Any]:
    """What axe finds wrong, having made sure that it looked: also at buttons, where there are any."""
    # Half way through a transition the colours are neither the old ones nor the new ones.
    page.evaluate(SETTLED)
    report: dict[str, list[Any]] = page.evaluate(RUN)
    looked = {"color-contrast", "target-size", "button-name"} if buttons else {"color-contrast"}
    assert looked <= set(report["passed"])
    return report["found"]
