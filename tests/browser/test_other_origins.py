"""A page of another origin that the settings allow: it may send and read every header, at `/mcp` as at REST."""

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page

from tests.support.access import Site
from tests.support.gateway import RunningGateway
from tests.support.installed import needs
from tests.support.origins import blank_page

ASK = """async ([url, method, headers, body]) => {
    const answer = await fetch(url, { method, headers, body: body && JSON.stringify(body) });
    return { status: answer.status, headers: Object.fromEntries(answer.headers), text: await answer.text() };
}"""
HELLO = {
    "jsonrpc": "2.0",
    "id": 1,
    "method": "initialize",
    "params": {
        "protocolVersion": "2025-06-18",
        "capabilities": {},
        "clientInfo": {"name": "a page", "version": "1"},
    },
}


@pytest.fixture(scope="module")
def origin() -> Iterator[str]:
    with blank_page() as origin:
        yield origin


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return Site(tmp_path_factory.mktemp("origins"))


@pytest.fixture(scope="module")
def token(site: Site) -> str:
    return site.token("page", "operator")


@pytest.fixture(scope="module")
def gateway(domain: int, site: Site, token: str, origin: str) -> Iterator[RunningGateway]:
    with site.gateway(domain, mcp="true", allowed_origins=origin) as gateway:
        gateway.http.headers["Authorization"] = f"Bearer {token}"
        gateway.wait_until_stored()
        yield gateway


@pytest.fixture
def page(browser: Browser, origin: str) -> Iterator[Page]:
    with browser.new_context() as context:
        page = context.new_page()
        blocked: list[str] = []

        def hear(message: ConsoleMessage) -> None:
            if "CORS" in message.text:
                blocked.append(message.text)

        page.on("console", hear)
        page.goto(origin)
        yield page
        assert blocked == []


def ask(page: Page, url: str, method: str = "GET", body: object = None, **headers: str) -> dict[str, Any]:
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    answer: dict[str, Any] = page.evaluate(ASK, [url, method, named, body])
    return answer


@needs("agents")
def test_an_agent_in_a_page(page: Page, gateway: RunningGateway, token: str) -> None:
    """With the headers of each revision of the Model Context Protocol."""
    bearer = {"authorization": f"Bearer {token}", "content_type": "application/json"}
    bearer |= {"accept": "application/json, text/event-stream"}
    hello = ask(page, f"{gateway.url}/mcp", "POST", HELLO, **bearer)
    assert hello["status"] == 200
    more = {"mcp_protocol_version": "2025-06-18", "mcp_session_id": "1", "mcp_method": "tools/list"}
    listed = {"jsonrpc": "2.0", "id": 2, "method": "tools/list"}
    tools = ask(page, f"{gateway.url}/mcp", "POST", listed, **bearer, **more)
    assert tools["status"] == 200
    assert '"stop_robots"' in tools["text"]
    stream = ask(page, f"{gateway.url}/mcp", **bearer, **more, last_event_id="1")
    assert stream["status"] == 405


def test_a_page_reads_every_header(page: Page, gateway: RunningGateway, token: str) -> None:
    anonymous = ask(page, f"{gateway.url}/dock", "POST", {}, content_type="application/json")
    assert (anonymous["status"], anonymous["headers"]["www-authenticate"]) == (401, "Bearer")
    bearer = {"authorization": f"Bearer {token}"}
    graph = ask(page, f"{gateway.url}/graph", **bearer)
    tag = graph["headers"]["etag"]
    known = ask(
        page, f"{gateway.url}/graph", **bearer, if_none_match=tag, traceparent="00-" + "1" * 32 + "-" + "2" * 16
    )
    assert known["status"] in (200, 304)  # the graph may have changed
    bearer["content_type"] = "application/json"
    absent = ask(page, f"{gateway.url}/dock", "POST", {}, **bearer, idempotency_key="1", prefer="wait=1")
    assert absent["status"] == 503
    assert {"retry-after", "x-request-id"} <= absent["headers"].keys()


def test_a_page_loads_files_with_crossorigin(page: Page, gateway: RunningGateway) -> None:
    """Pictures and scripts without it are loaded by no other page: the browser does not say whose page it is."""
    load = """([url, crossOrigin]) => new Promise((resolve) => {
        const script = document.createElement("script");
        if (crossOrigin) script.crossOrigin = "anonymous";
        script.onload = () => resolve(true);
        script.onerror = () => resolve(false);
        script.src = url;
        document.head.append(script);
    })"""
    file = f"{gateway.url}/color-scheme.js"
    assert page.evaluate(load, [file, True]) is True
    assert page.evaluate(load, [file, False]) is False
