"""Notifications by clicking: a webhook is added and tested, and receives a stop; the browser announces alerts."""

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Page, expect

from tests.browser.axe import find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import RunningGateway
from tests.support.waiting import wait_until
from tests.support.webhooks import Receiver, running_receiver

# Keeps what the browser would show and play.
RECORD = """
window.shown = [];
class Recorded {
  static permission = "default";
  static async requestPermission() { return (Recorded.permission = "granted"); }
  constructor(title, options) { window.shown.push(title); }
  close() {}
}
window.Notification = Recorded;
window.notes = 0;
const start = OscillatorNode.prototype.start;
OscillatorNode.prototype.start = function (...times) { window.notes += 1; return start.apply(this, times); };
"""


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    with running_receiver() as receiver:
        yield receiver


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
    for width in (390, 768):
        page.set_viewport_size({"width": width, "height": 900})
        expect_no_sideways_scrolling(page)
    page.set_viewport_size({"width": 1440, "height": 1000})

    page.get_by_role("button", name="Remove Control room").click()
    dialog.get_by_role("button", name="Remove", exact=True).click()
    expect(page.get_by_text("A webhook tells another system")).to_be_visible()
    assert gateway.http.get("/webhooks").json() == {"webhooks": []}


def test_the_browser_announces_alerts_as_they_begin(page: Page, gateway: RunningGateway) -> None:
    page.add_init_script(RECORD)
    page.goto(f"{gateway.url}/ui/notifications")
    page.get_by_label("Notifications on this computer").check(force=True)
    page.get_by_label("Sound").check(force=True)
    wait_until(lambda: page.evaluate("window.notes") == 1, "a note")
    page.get_by_role("button", name="Try it").click()
    wait_until(lambda: page.evaluate("[window.notes, window.shown.length]") == [3, 1], "two more and a notification")
    page.get_by_role("link", name="Goals").click()  # on any page
    gateway.http.post("/stop").raise_for_status()
    wait_until(lambda: page.evaluate("window.notes") == 5, "the notes of a critical alert")
    assert page.evaluate("window.shown") == ["Test", "Robot: Stopped"]
    page.reload()  # what there is already is not announced
    expect(page.get_by_test_id("alert-count").first).to_be_visible()
    page.get_by_role("button", name="Release").first.wait_for()
    assert page.evaluate("window.shown") == []
