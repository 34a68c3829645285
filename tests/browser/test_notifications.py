"""Notifications by clicking: the browser announces alerts."""

from playwright.sync_api import Page, expect

from tests.support.gateway import RunningGateway
from tests.support.waiting import wait_until

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
