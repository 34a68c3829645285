"""A webhook by clicking: it is added and tested, receives a stop, and is removed."""

import re

from playwright.sync_api import Page, expect

from tests.browser.axe import find_violations
from tests.browser.layout import find_layout_faults
from tests.support.gateway import RunningGateway
from tests.support.waiting import wait_until
from tests.support.webhooks import Receiver


def test_a_webhook_is_added_tested_and_told_of_a_stop(page: Page, gateway: RunningGateway, receiver: Receiver) -> None:
    page.get_by_role("link", name="Notifications").click()
    page.get_by_role("button", name="New webhook").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Name", exact=True).fill("Control room")
    dialog.get_by_label("Address").fill(receiver.url)
    dialog.get_by_label("Your name").fill("Ada")
    assert find_violations(page) == []
    dialog.get_by_role("button", name="Save").click()
    expect(dialog).to_contain_text("whsec_")
    dialog.get_by_role("button", name="Close").click()
    webhook = page.get_by_role("list", name="Webhooks").get_by_role("listitem").first
    expect(webhook).to_contain_text(re.compile("All alerts. All robots.*Changed by Ada", re.DOTALL))

    page.get_by_role("button", name="Test Control room").click()
    expect(webhook).to_contain_text("The test was delivered: the answer was 204.")
    gateway.http.post("/stop").raise_for_status()
    wait_until(lambda: ("alert.raised", "stop_latched") in receiver.seen(), "the stop")
    webhook.get_by_text("Last delivered").click()
    row = webhook.get_by_role("row").filter(has_text="Stopped")
    expect(row).to_contain_text(re.compile("Stopped, Robot.*Began.*Delivered", re.DOTALL))
    assert find_violations(page) == []
    assert find_layout_faults(page) == []

    page.get_by_role("button", name="Remove Control room").click()
    dialog.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_text("A webhook tells another system")).to_be_visible()
    assert gateway.http.get("/webhooks").json() == {"webhooks": []}
