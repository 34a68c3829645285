"""A login with an identity provider in a real browser: there, back, out; and what the page says when it fails."""

import subprocess
import sys
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.axe import find_violations
from tests.browser.conftest import PATIENCE_MS
from tests.browser.width import expect_no_sideways_scrolling
from tests.extensions.single_sign_on.provider import oidc_settings, running_mock
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway

ADA = {"sub": "4711", "preferred_username": "ada", "roles": ["ops"]}
EVE = {"sub": "4712", "preferred_username": "eve", "roles": ["guests"]}
LOGIN = "Log in with Site login"


@pytest.fixture(scope="module")
def gateway(domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningGateway]:
    database_url = f"sqlite:///{tmp_path_factory.mktemp('provider')}/history.db"
    command = ["-m", "dock_gateway", "token", "create", "admin", "--role", "admin", "--database-url", database_url]
    admin = subprocess.run([sys.executable, *command], check=True, capture_output=True, text=True).stdout.strip()
    with running_mock(ADA, EVE) as issuer, running_dock_server(domain):
        settings = {"authentication": "true", "database_url": database_url, **oidc_settings(issuer)}
        with running_gateway(domain, **settings) as gateway:
            gateway.wait_until_ready()
            gateway.http.headers["Authorization"] = f"Bearer {admin}"
            yield gateway


@pytest.fixture
def page(browser: Browser, gateway: RunningGateway) -> Iterator[Page]:
    with browser.new_context(reduced_motion="reduce", viewport={"width": 1440, "height": 1000}) as context:
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        page.goto(f"{gateway.url}/ui/goals?status=succeeded")
        yield page


def test_a_person_logs_in_and_is_logged_out_by_an_admin(page: Page, gateway: RunningGateway) -> None:
    link = page.get_by_role("link", name=LOGIN)
    expect(link).to_be_visible()
    expect(page.get_by_label("Name", exact=True)).to_be_visible()
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        assert find_violations(page) == []
    page.set_viewport_size({"width": 320, "height": 900})
    expect_no_sideways_scrolling(page)
    page.set_viewport_size({"width": 1440, "height": 1000})
    link.focus()
    page.keyboard.press("Enter")
    page.get_by_role("button", name="4711", exact=True).click()
    expect(page).to_have_url(f"{gateway.url}/ui/goals?status=succeeded")
    expect(page.get_by_test_id("connection")).to_have_text("live")
    names = {cookie["name"]: cookie for cookie in page.context.cookies()}
    assert names["dock-gateway"]["sameSite"] == "Strict"
    assert names["dock-gateway"]["httpOnly"] is True
    assert "dock-gateway-login" not in names
    page.reload()
    page.get_by_role("button", name="Logged in as oidc:ada, operator").click()
    expect(page.get_by_role("menuitem", name="Log out everywhere")).to_be_visible()
    expect(page.get_by_role("menuitem", name="Change password …")).to_have_count(0)
    gateway.http.delete("/people/oidc:ada/sessions").raise_for_status()
    expect(page.get_by_role("alert").filter(has_text="Your login has ended")).to_be_visible()


def test_what_the_page_says_when_it_fails(page: Page, gateway: RunningGateway) -> None:
    page.get_by_role("link", name=LOGIN).click()
    page.get_by_role("button", name="4712", exact=True).click()
    expect(page.get_by_role("alert").filter(has_text="you have no role here")).to_be_visible()
    expect(page).to_have_url(f"{gateway.url}/ui/goals?status=succeeded")
    assert find_violations(page) == []
    page.get_by_role("link", name=LOGIN).click()
    page.get_by_role("button", name="Deny").click()
    expect(page.get_by_role("alert").filter(has_text="The login was canceled")).to_be_visible()
    page.goto(f"{gateway.url}/session/oidc/callback?code=stolen&state=stolen")
    expect(page.get_by_role("alert").filter(has_text="The login with Site login has failed")).to_be_visible()
    expect(page).to_have_url(f"{gateway.url}/")
