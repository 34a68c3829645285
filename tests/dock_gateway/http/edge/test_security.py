"""Every answer tells browsers what they may do with it, whichever part of the gateway made it."""

import asyncio

import httpx2
import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient, WebSocketDenialResponse

from dock_gateway.app import create_app
from dock_gateway.http.edge.security import CONTENT_SECURITY_POLICY, PAGE_POLICY, SECURITY_HEADERS, SecurityHeaders
from dock_gateway.settings import Settings

NAMES = {
    "Content-Security-Policy",
    "X-Content-Type-Options",
    "X-Frame-Options",
    "Referrer-Policy",
    "Cross-Origin-Resource-Policy",
}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> TestClient:
    folder = tmp_path_factory.mktemp("dashboard")
    (folder / "assets").mkdir()
    (folder / "index.html").write_text("<title>the page</title>")
    (folder / "color-scheme.js").write_text("1")
    (folder / "assets" / "index-abc.js").write_text("1")
    app = create_app(Settings(dashboard_dir=folder))

    @app.get("/bug")
    async def bug() -> None:
        raise RuntimeError

    return TestClient(SecurityHeaders(app), base_url="http://127.0.0.1:8000", raise_server_exceptions=False)


def check(headers: httpx2.Headers, policy: str) -> None:
    assert set(SECURITY_HEADERS) == NAMES
    for name, value in SECURITY_HEADERS.items():
        assert headers.get_list(name) == [policy if name == CONTENT_SECURITY_POLICY else value], name


DATA = [
    ("GET", "/openapi.json", 200),
    ("GET", "/nowhere", 404),
    ("DELETE", "/dock", 405),
    ("OPTIONS", "/dock", 204),
    ("GET", "/bug", 500),
    ("GET", "/assets/index-abc.js", 200),
    ("GET", "/assets/none.js", 404),
    ("GET", "/color-scheme.js", 200),
    ("GET", "/swagger/swagger-ui.css", 200),
    ("GET", "/docs/start.js", 200),
]
CACHED = {
    "/assets/index-abc.js": "public, max-age=31536000, immutable",
    "/color-scheme.js": "no-cache",
    "/docs/start.js": "no-cache",
    "/swagger/swagger-ui.css": "no-cache",
}


@pytest.mark.parametrize(("method", "path", "status"), DATA)
def test_data(client: TestClient, method: str, path: str, status: int) -> None:
    """No cache keeps an answer that says nothing of caches."""
    response = client.request(method, path)
    assert response.status_code == status
    check(response.headers, SECURITY_HEADERS[CONTENT_SECURITY_POLICY])
    assert response.headers.get_list("Cache-Control") == [CACHED.get(path, "no-store")]


@pytest.mark.parametrize("path", ["/", "/ui/goals", "/docs"])
def test_pages(client: TestClient, path: str) -> None:
    response = client.get(path)
    assert response.status_code == 200
    check(response.headers, PAGE_POLICY)


def test_requests_of_other_pages_that_are_refused(client: TestClient) -> None:
    response = client.post("/dock", headers={"Origin": "https://evil.example"})
    assert response.status_code == 403
    check(response.headers, SECURITY_HEADERS[CONTENT_SECURITY_POLICY])
    with (
        pytest.raises(WebSocketDenialResponse) as refused,
        client.websocket_connect("/ws", headers={"Origin": "https://evil.example"}),
    ):
        pass
    check(refused.value.headers, SECURITY_HEADERS[CONTENT_SECURITY_POLICY])


@pytest.mark.parametrize("policy", [SECURITY_HEADERS[CONTENT_SECURITY_POLICY], PAGE_POLICY])
def test_nothing_may_frame_an_answer_or_run_what_stands_in_it(policy: str) -> None:
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["frame-ancestors"] == "'none'"
    assert rules["default-src"] == "'none'"
    assert "unsafe" not in rules.get("script-src", "")


def test_the_lifespan_passes() -> None:
    async def run() -> None:
        app = FastAPI()
        with TestClient(SecurityHeaders(app)):
            await asyncio.sleep(0)

    asyncio.run(run())
