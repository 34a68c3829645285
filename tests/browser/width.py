"""Whether a page fits into its window."""

from playwright.sync_api import Page

from tests.support.waiting import wait_until


def expect_no_sideways_scrolling(page: Page, what: str = "the page") -> None:
    """Wait until nothing of the page is beyond the right edge: after a resize it is laid out anew."""
    width = "document.documentElement.scrollWidth - window.innerWidth"
    wait_until(lambda: page.evaluate(width) <= 0, f"{what} without scrolling sideways")
