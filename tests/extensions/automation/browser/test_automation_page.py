"""Automatic docking by clicking: a rule is added, tried out, switched on and removed; its goal names it."""

import re

from playwright.sync_api import Page, expect

from tests.browser.axe import find_violations
from tests.browser.layout import find_layout_faults
from tests.support.gateway import LOW, RunningGateway


def test_a_rule_from_its_beginning_to_its_end(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Automatic docking").click()
    expect(page.get_by_text("No rules")).to_be_visible()
    page.get_by_role("button", name="New rule").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Name", exact=True).fill("Low battery")
    dialog.get_by_label("Battery below").fill("30")
    dialog.get_by_label("And idle for").fill("10")
    dialog.get_by_label("Your name").fill("Ada")
    dialog.get_by_role("button", name="Save").click()
    rule = page.get_by_role("list", name="Rules").get_by_role("listitem").first
    expect(rule).to_contain_text(re.compile("Battery below 30\\s%.*All robots.*Changed by Ada", re.DOTALL))

    mode = page.get_by_role("radiogroup", name="Mode of Low battery")
    mode.get_by_text("Dry run").click()
    decisions = page.get_by_role("region", name="Latest decisions").locator("tbody tr")
    expect(decisions).to_have_count(1)
    expect(decisions.first).to_contain_text(re.compile("Low battery.*Would dock.*Battery 24\\s%, idle for"))
    assert gateway.http.get("/goals").json()["goals"] == []

    mode.get_by_text("On", exact=True).click()
    expect(dialog).to_contain_text("This robot will drive to its dock without being asked")
    expect(dialog.get_by_role("listitem")).to_have_text(["Robot"])
    assert find_violations(page) == []
    dialog.get_by_role("button", name="Switch on").click()
    expect(decisions).to_have_count(2)
    expect(decisions.first).to_contain_text("Sent to dock")
    rule.get_by_text("Applies to one robot now").click()
    expect(rule).to_contain_text("A goal is running")
    assert find_violations(page) == []
    assert find_layout_faults(page) == []

    decisions.first.get_by_role("link", name="See the goal").click()
    page.get_by_role("link", name="Automatic docking: Low battery").click()
    decisions.first.get_by_role("link", name="Robot", exact=True).click()
    page.get_by_role("link", name="Automatic docking on (Low battery)").click()
    page.get_by_role("button", name="Remove Low battery").click()
    dialog.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_text("No rules")).to_be_visible()
    assert gateway.http.get("/automation/rules").json() == {"rules": []}
