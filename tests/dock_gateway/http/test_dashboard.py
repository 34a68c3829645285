"""Pages are served at / and /ui, never in place of the API; assets are cached for ever, pages never."""

from pathlib import Path

import pytest
from fastapi import FastAPI
from starlette.testclient import TestClient

from dock_gateway.http.dashboard import find_dashboard, install_dashboard
from dock_gateway.http.docs import install_docs
from dock_gateway.http.problems import install_problems
from dock_gateway.settings import Settings


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<title>the page</title>")
    (tmp_path / "favicon.svg").write_text("<svg/>")
    (tmp_path / "assets" / "index-abc.js").write_text("1")
    (tmp_path.parent / "secret.txt").write_text("secret")
    return tmp_path


def client(folder: Path | None, monkeypatch: pytest.MonkeyPatch) -> TestClient:
    app = FastAPI()
    install_problems(app)
    if folder is None:
        monkeypatch.setattr("dock_gateway.http.dashboard.find_dashboard", lambda _: None)
    install_dashboard(app, Settings(dashboard_dir=folder))
    return TestClient(app)


@pytest.mark.parametrize("path", ["/", "/ui/goals", "/ui/robots/robot1"])
def test_pages(folder: Path, monkeypatch: pytest.MonkeyPatch, path: str) -> None:
    response = client(folder, monkeypatch).get(path)
    assert response.status_code == 200
    assert "the page" in response.text
    assert response.headers["cache-control"] == "no-cache"
    assert "script-src 'self'" in response.headers["content-security-policy"]


def test_assets(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    http = client(folder, monkeypatch)
    assert "immutable" in http.get("/assets/index-abc.js").headers["cache-control"]
    assert http.get("/favicon.svg").headers["cache-control"] == "no-cache"


@pytest.mark.parametrize(
    "path",
    [
        "/nothing",
        "/nothing.js",
        "/assets/none.js",
        f"/{'x' * 300}.js",
        f"/assets/{'x' * 300}.js",
        "/%00.js",
        "/assets/%00.js",
        "/assets",
        "/assets/../index.html/x",
        "/..%2fsecret.txt",
        "/%2e%2e%2fsecret.txt",
    ],
)
def test_what_is_not_there_is_a_problem_document(folder: Path, monkeypatch: pytest.MonkeyPatch, path: str) -> None:
    response = client(folder, monkeypatch).get(path)
    assert response.status_code == 404
    assert response.headers["content-type"] == "application/problem+json"


def test_without_a_build_the_page_says_what_to_run(monkeypatch: pytest.MonkeyPatch) -> None:
    http = client(None, monkeypatch)
    assert "make setup" in http.get("/").text
    assert http.get("/favicon.svg").status_code == 404


def test_the_folder_that_is_set_comes_first(folder: Path) -> None:
    assert find_dashboard(Settings(dashboard_dir=folder)) == folder


def test_a_page_can_be_asked_for_with_head(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    http = client(folder, monkeypatch)
    for path in ("/", "/ui/goals", "/favicon.svg", "/assets/index-abc.js"):
        response = http.head(path)
        assert (response.status_code, response.content) == (200, b"")
        assert response.headers.items() >= {"content-length": http.get(path).headers["content-length"]}.items()


def test_a_page_that_has_not_changed_keeps_its_policy(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cache takes over the headers of a 304 response."""
    http = client(folder, monkeypatch)
    page = http.get("/")
    again = http.get("/", headers={"If-None-Match": page.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    for name in ("content-security-policy", "cache-control", "vary", "etag"):
        assert again.headers[name] == page.headers[name]


def test_compressed_files_have_no_address(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "index.html.br").write_bytes(b"x")
    (folder / "assets" / "index-abc.js.gz").write_bytes(b"x")
    http = client(folder, monkeypatch)
    assert http.get("/index.html.br").status_code == 404
    assert http.get("/assets/index-abc.js.gz").status_code == 404


def test_the_page_of_the_api_is_sent_compressed_and_once() -> None:
    app = FastAPI()
    install_docs(app)
    http = TestClient(app)
    path = "/swagger/swagger-ui-bundle.js"
    answer = http.get(path, headers={"Accept-Encoding": "gzip"})
    assert answer.headers["content-encoding"] == "gzip"
    assert len(answer.content) > 3 * answer.num_bytes_downloaded
    assert http.get(path, headers={"If-None-Match": answer.headers["etag"]}).status_code == 304
