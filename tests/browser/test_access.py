"""A gateway that asks for a login: with a password or a token, what a role may do, a login that ends, users, tokens."""

import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.browser.axe import find_violations
from tests.browser.conftest import PATIENCE_MS
from tests.browser.layout import find_layout_faults
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import RunningGateway, ready_gateway
from tests.support.installed import needs

PASSWORD = "correct horse battery staple"


@pytest.fixture(scope="module")
def database_url(tmp_path_factory: pytest.TempPathFactory) -> str:
    return f"sqlite:///{tmp_path_factory.mktemp('access')}/history.db"


@pytest.fixture(scope="module")
def admin(database_url: str) -> str:
    """The secret of the first token."""
    command = ["-m", "dock_gateway", "token", "create", "admin", "--role", "admin", "--database-url", database_url]
    return subprocess.run([sys.executable, *command], check=True, capture_output=True, text=True).stdout.strip()


@pytest.fixture(scope="module")
def gateway(domain: int, database_url: str, admin: str) -> Iterator[RunningGateway]:
    settings = {"authentication": "true", "database_url": database_url}
    with ready_gateway(domain, **settings) as gateway:
        gateway.http.headers["Authorization"] = f"Bearer {admin}"
        yield gateway


@pytest.fixture(scope="module")
def secrets(gateway: RunningGateway, admin: str) -> dict[str, str]:
    """The secrets of tokens that are called as their roles."""
    roles = {role: create(gateway, role, role)["secret"] for role in ("viewer", "operator")}
    return {**roles, "admin": admin}


def create(gateway: RunningGateway, name: str, role: str) -> dict[str, str]:
    created: dict[str, str] = gateway.http.post("/tokens", json={"name": name, "role": role}).raise_for_status().json()
    return created


def add_user(gateway: RunningGateway, name: str, role: str) -> None:
    gateway.http.put(f"/users/{name}", json={"role": role, "password": PASSWORD}).raise_for_status()


@pytest.fixture
def page(browser: Browser, gateway: RunningGateway) -> Iterator[Page]:
    """The page that asks for a login."""
    with browser.new_context(reduced_motion="reduce", viewport={"width": 1440, "height": 1000}) as context:
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        page.goto(f"{gateway.url}/ui/goals")
        yield page
    gateway.http.delete("/stop")


def log_in_as(page: Page, name: str, password: str = PASSWORD) -> None:
    page.get_by_label("Name", exact=True).fill(name)
    page.get_by_label("Password", exact=True).fill(password)
    page.get_by_label("Password", exact=True).press("Enter")


def log_in(page: Page, secret: str) -> None:
    page.get_by_role("button", name="Log in with a token").click()
    page.get_by_label("Token", exact=True).fill(secret)
    page.get_by_label("Token", exact=True).press("Enter")


def expect_live(page: Page) -> None:
    expect(page.get_by_test_id("connection")).to_have_text("live")


def test_a_user_logs_in_changes_the_password_and_logs_out_everywhere(
    page: Page, browser: Browser, gateway: RunningGateway
) -> None:
    add_user(gateway, "ada", "operator")
    streams: list[str] = []
    page.on("websocket", lambda socket: streams.append(socket.url))
    page.reload()
    expect(page.get_by_label("Name", exact=True)).to_be_focused()
    expect(page.get_by_label("Password", exact=True)).to_have_attribute("type", "password")
    assert find_violations(page) == []
    assert find_layout_faults(page) == []
    log_in_as(page, "ada", "wrong")
    expect(page.get_by_text("The name or the password is wrong")).to_be_visible()
    assert streams == []
    log_in_as(page, "ada")
    expect(page.get_by_role("heading", name="Goals", level=1)).to_be_visible()  # as the address says
    expect_live(page)

    with browser.new_context() as context:
        other = context.new_page()
        other.set_default_timeout(PATIENCE_MS)
        other.goto(f"{gateway.url}/ui/goals")
        log_in_as(other, "ada")
        expect_live(other)
        page.get_by_role("button", name="Logged in as ada, operator").click()
        page.get_by_role("menuitem", name="Change password …").click()
        dialog = page.get_by_role("dialog")
        dialog.get_by_label("Old password", exact=True).fill(PASSWORD)
        dialog.get_by_label("New password", exact=True).fill("another horse, another battery")
        assert find_violations(page) == []
        dialog.get_by_role("button", name="Change", exact=True).click()
        expect(dialog).to_have_count(0)
        expect(other.get_by_role("alert").filter(has_text="Your login has ended")).to_be_visible()
        expect_live(page)
        expect(page.get_by_role("alert").filter(has_text="Your login has ended")).to_have_count(0)
        other.get_by_role("button", name="Log in").click()
        log_in_as(other, "ada", "another horse, another battery")
        expect_live(other)
        page.get_by_role("button", name="Logged in as ada, operator").click()
        page.get_by_role("menuitem", name="Log out everywhere").click()
        expect(page.get_by_label("Password", exact=True)).to_be_visible()
        expect(other.get_by_role("alert").filter(has_text="Your login has ended")).to_be_visible()


def test_an_admin_adds_changes_and_removes_users(page: Page, gateway: RunningGateway) -> None:
    add_user(gateway, "root", "admin")
    log_in_as(page, "root")
    expect_live(page)
    page.get_by_role("button", name="Logged in as root, admin").click()
    page.get_by_role("menuitem", name="Users").click()
    page.get_by_role("button", name="New user").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Name", exact=True).fill("bob")
    dialog.get_by_label("Role").select_option("supervisor")
    dialog.get_by_label("Password", exact=True).fill(PASSWORD)
    assert find_violations(page) == []
    dialog.get_by_role("button", name="Add", exact=True).click()
    expect(dialog).to_have_count(0)
    bob = page.get_by_role("list", name="Users").get_by_role("listitem").filter(has_text="bob")
    expect(bob).to_contain_text("by root")
    assert find_violations(page) == []
    assert find_layout_faults(page) == []
    page.get_by_role("button", name="Edit bob").click()
    expect_no_sideways_scrolling(page)
    dialog.get_by_label("Role").select_option("viewer")
    dialog.get_by_role("switch", name="Disabled").focus()
    page.keyboard.press("Space")
    dialog.get_by_role("button", name="Save").click()
    expect(bob).to_contain_text("viewer")
    expect(bob).to_contain_text("disabled")
    page.get_by_role("button", name="Remove bob").click()
    dialog.get_by_role("button", name="Remove", exact=True).click()
    expect(bob).to_have_count(0)


def test_a_token_is_the_second_way(page: Page, gateway: RunningGateway, secrets: dict[str, str]) -> None:
    streams: list[str] = []
    page.on("websocket", lambda socket: streams.append(socket.url))
    page.reload()
    page.get_by_role("button", name="Log in with a token").click()
    field = page.get_by_label("Token", exact=True)
    expect(field).to_be_focused()
    expect(field).to_have_attribute("type", "password")
    page.get_by_role("button", name="Show the token").click()
    expect(field).to_have_attribute("type", "text")
    assert find_violations(page) == []
    page.set_viewport_size({"width": 320, "height": 900})
    expect_no_sideways_scrolling(page)
    page.set_viewport_size({"width": 1440, "height": 1000})

    page.get_by_role("button", name="Log in", exact=True).click()
    expect(page.get_by_text("Enter your token.")).to_be_visible()
    field.fill("dgw_wrong")
    field.press("Enter")
    expect(page.get_by_text("This token is not valid")).to_be_visible()
    assert streams == []

    field.fill(secrets["viewer"])
    field.press("Enter")
    expect(page.get_by_role("heading", name="Goals", level=1)).to_be_visible()  # as the address says
    expect_live(page)
    page.get_by_role("button", name="Logged in as viewer, viewer").click()
    expect(page.get_by_role("menuitem", name="Tokens")).to_have_count(0)
    page.get_by_role("menuitem", name="Log out").click()
    password = page.get_by_label("Password", exact=True)
    expect(password).to_be_visible()
    page.reload()
    expect(password).to_be_visible()


def test_what_a_viewer_may_not_do_says_why(page: Page, gateway: RunningGateway, secrets: dict[str, str]) -> None:
    log_in(page, secrets["viewer"])
    expect_live(page)
    page.get_by_role("link", name="Overview").click()
    dock = page.get_by_role("button", name="Dock", exact=True)
    expect(dock).to_be_disabled()
    expect(dock).to_have_accessible_description("Needs the role operator; you are viewer.")
    dock.hover(force=True)
    expect(page.get_by_role("tooltip")).to_have_text("Needs the role operator; you are viewer.")
    page.get_by_role("button", name="Stop", exact=True).click()
    banner = page.get_by_test_id("stop-banner")
    expect(banner).to_contain_text("stopped by viewer")
    release = banner.get_by_role("button", name="Release")
    expect(release).to_have_accessible_description("Needs the role supervisor; you are viewer.")
    assert find_violations(page) == []
    page.goto(f"{gateway.url}/ui/tokens")
    expect(page.get_by_role("main")).to_contain_text("Needs the role admin; you are viewer.")


@needs("webhooks")
def test_a_viewer_does_not_see_webhooks(page: Page, secrets: dict[str, str]) -> None:
    log_in(page, secrets["viewer"])
    expect_live(page)
    page.get_by_role("link", name="Notifications").click()
    secret = "The addresses of webhooks are often secret. Needs the role supervisor; you are viewer."
    expect(page.get_by_text(secret)).to_be_visible()


def test_an_operator_allows_the_goal_of_an_agent(page: Page, gateway: RunningGateway, secrets: dict[str, str]) -> None:
    agent = create(gateway, "shift planner", "agent")
    log_in(page, secrets["operator"])
    expect_live(page)
    with ThreadPoolExecutor() as pool:
        headers = {"Authorization": f"Bearer {agent['secret']}"}
        sent = pool.submit(gateway.http.post, "/dock", headers=headers, timeout=120)
        question = page.get_by_test_id("approval")
        expect(question).to_contain_text("shift planner wants to dock")
        assert find_violations(page) == []
        assert find_layout_faults(page) == []
        question.get_by_role("button", name="Allow").click()
        answer = sent.result()
    assert answer.status_code == 202, answer.text
    expect(question).to_be_hidden()
    gateway.stop_once()


def test_a_login_that_ends_is_said_and_another_one_goes_on(
    page: Page, gateway: RunningGateway, secrets: dict[str, str]
) -> None:
    created = create(gateway, "Bob", "operator")
    log_in(page, created["secret"])
    expect_live(page)
    page.get_by_role("link", name="Overview").click()
    expect(page.get_by_role("region", name="Docking", exact=True)).to_be_visible()
    page.add_init_script("window.reloaded = true")
    gateway.http.delete(f"/tokens/{created['id']}").raise_for_status()
    ended = page.get_by_role("alert").filter(has_text="Your login has ended")
    expect(ended).to_be_visible()
    expect(page.get_by_test_id("connection")).to_have_text("logged out")
    expect(page.get_by_role("region", name="Docking", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Stop", exact=True)).to_be_enabled()
    assert find_violations(page) == []
    streams: list[str] = []
    page.on("websocket", lambda socket: streams.append(socket.url))
    page.wait_for_timeout(2500)  # longer than the first attempts of a stream are apart
    assert streams == []

    ended.get_by_role("button", name="Log in").click()
    log_in(page, secrets["operator"])
    expect(ended).to_have_count(0)
    expect_live(page)
    expect(page.get_by_role("button", name="Logged in as operator, operator")).to_be_visible()
    assert page.evaluate("window.reloaded") is None


def test_an_admin_creates_and_revokes_tokens(page: Page, gateway: RunningGateway, secrets: dict[str, str]) -> None:
    log_in(page, secrets["admin"])
    expect_live(page)
    page.get_by_role("button", name="Logged in as admin, admin").click()
    page.get_by_role("menuitem", name="Tokens").click()
    page.get_by_role("button", name="New token").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Name", exact=True).fill("Night shift")
    dialog.get_by_label("Role").select_option("supervisor")
    robots = dialog.get_by_label("Robots")
    robots.fill("hall_a")
    robots.press("Enter")
    dialog.get_by_label("Valid for (days)").fill("7")
    dialog.get_by_role("button", name="Create").click()
    expect(dialog).to_contain_text("Names begin with / or *")
    robots.press("Backspace")
    robots.fill("/hall_a/*")
    robots.press("Enter")
    assert find_violations(page) == []
    dialog.get_by_role("button", name="Create").click()
    expect(dialog).to_contain_text("it is not shown again")
    secret = dialog.locator("pre").inner_text()
    identity = gateway.http.get("/session", headers={"Authorization": f"Bearer {secret}"}).json()
    assert identity["principal"] == {
        "name": "Night shift",
        "kind": "token",
        "role": "supervisor",
        "robots": ["/hall_a/*"],
        "actions": [],
        "topics": [],
    }
    dialog.get_by_role("button", name="Close").click()
    token = page.get_by_role("list", name="Tokens").get_by_role("listitem").filter(has_text="Night shift")
    expect(token).to_contain_text("by admin")
    expect(token).to_contain_text("/hall_a/*")
    assert find_violations(page) == []
    assert find_layout_faults(page) == []
    page.get_by_role("button", name="Revoke Night shift").click()
    expect(dialog).to_contain_text("Goals that Night shift has sent go on")
    dialog.get_by_role("button", name="Revoke", exact=True).click()
    expect(token).to_have_count(0)


def test_a_phone_has_the_login_in_its_menu(page: Page, secrets: dict[str, str]) -> None:
    page.set_viewport_size({"width": 320, "height": 900})
    log_in(page, secrets["admin"])
    expect_live(page)
    page.get_by_role("button", name="Pages").click()
    expect(page.get_by_text("Logged in as admin, admin")).to_be_visible()
    expect_no_sideways_scrolling(page)
    assert find_violations(page) == []
    page.get_by_role("link", name="Tokens").click()
    expect(page.get_by_role("heading", name="Tokens")).to_be_visible()


def test_an_admin_reads_the_audit_log(page: Page, gateway: RunningGateway, secrets: dict[str, str]) -> None:
    viewer = {"Authorization": f"Bearer {secrets['viewer']}"}
    gateway.http.post("/stop").raise_for_status()
    assert gateway.http.delete("/stop", headers=viewer).status_code == 403
    for _ in range(60):
        gateway.http.delete("/stop").raise_for_status()
    log_in(page, secrets["admin"])
    expect_live(page)
    page.get_by_role("button", name="Logged in as admin, admin").click()
    page.get_by_role("menuitem", name="Audit").click()
    rows = page.get_by_role("table").locator("tbody tr")
    expect(rows).to_have_count(50)
    expect(rows.filter(has_text="Log in").first).to_contain_text("admin")
    assert find_violations(page) == []
    page.get_by_role("button", name="Load older records").press("Enter")
    expect(rows.nth(55)).to_be_visible()
    page.get_by_label("Outcome").select_option("Refused")
    page.get_by_label("What").select_option("Release the stop")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("viewer")
    expect(rows).to_contain_text("Role required")
    who = page.get_by_label("Who", exact=True)
    who.fill("nobody")
    who.press("Enter")
    expect(page.get_by_text("No record fits")).to_be_visible()
    assert "principal=nobody" in page.url
    page.get_by_label("Goal id").fill("x")
    expect(page.get_by_text("The whole id of a goal")).to_be_visible()
    assert find_violations(page) == []
    page.get_by_role("button", name="Clear filters").click()
    expect(rows.nth(55)).to_be_visible()  # as it was
    with page.expect_download() as download:
        page.get_by_role("link", name="Export CSV of these records").click()
    assert download.value.path().read_text().startswith("sequence,id,acted_at,principal")
    assert find_layout_faults(page) == []
    assert find_violations(page) == []
