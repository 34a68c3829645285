"""Numbers and dates are written in the browser's language."""

import re

from playwright.sync_api import Browser, expect

from tests.support.gateway import LOW, RunningGateway


def test_a_german_browser(browser: Browser, gateway: RunningGateway) -> None:
    with browser.new_context(locale="de-DE", reduced_motion="reduce") as context:
        page = context.new_page()
        page.goto(gateway.url)
        gateway.publish(LOW)
        expect(page.get_by_role("region", name="Battery", exact=True)).to_contain_text(re.compile(r"\d,\d+ V"))
        page.get_by_role("button", name="Dock", exact=True).click()
        page.get_by_role("dialog").get_by_role("button", name="Dock", exact=True).click()
        expect(page.get_by_test_id("goal-status")).to_have_text("executing")
        assert re.findall(r".*\d\.\d.*", page.locator("main").inner_text()) == []
        page.get_by_role("link", name="Goals", exact=True).click()
        expect(page.get_by_role("table").locator("time").first).to_have_attribute(
            "title", re.compile(r"^\w+(tag|woch), ")
        )
