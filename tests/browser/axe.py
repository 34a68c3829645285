"""WCAG 2.2 AA and best practice on a page as a browser draws it, by axe."""

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

AXE = Path(__file__).parents[2] / "frontend/node_modules/axe-core/axe.min.js"
SETTLED = "Promise.allSettled(document.getAnimations().map((animation) => animation.finished))"
# Dialogs and tooltips stand outside of all landmarks. In the dark scheme, contrast is all that can differ.
RUN = """async (scheme) => {
    const tags = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];
    const rules = {"target-size": {enabled: true}, region: {enabled: false}};
    const all = {runOnly: {type: "tag", values: tags}, rules};
    const contrast = {runOnly: {type: "rule", values: ["color-contrast"]}};
    const {violations, passes} = await axe.run(document, scheme === "light" ? all : contrast);
    return {
        found: violations.flatMap(({id, nodes}) => nodes.map((node) => [scheme, id, node.html, node.failureSummary])),
        passed: passes.map(({id}) => id),
    };
}"""


def find_violations(page: Page, *, buttons: bool = True) -> list[Any]:
    """What axe finds wrong in either colour scheme; the page is light then.

    Makes sure that axe looked: also at buttons, where there are any.
    """
    if not AXE.exists():
        pytest.fail(f"{AXE} is missing: run npm ci in frontend/")
    if not page.evaluate("'axe' in globalThis"):
        page.evaluate(AXE.read_text(encoding="utf-8"))
    found = []
    for scheme, light in (("dark", False), ("light", True)):
        page.emulate_media(color_scheme="light" if light else "dark", reduced_motion="reduce")
        expect(page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)
        # Half way through a transition the colours are neither the old ones nor the new ones.
        page.evaluate(SETTLED)
        report: dict[str, list[Any]] = page.evaluate(RUN, scheme)
        looked = {"color-contrast", "target-size", "button-name"} if buttons and light else {"color-contrast"}
        assert looked <= set(report["passed"])
        found += report["found"]
    return found
