"""The dashboard's files. API paths never return HTML, and pages never shadow API paths."""

from collections.abc import Awaitable, Callable
from pathlib import Path

from fastapi import FastAPI
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from dock_gateway.http.edge.security import CONTENT_SECURITY_POLICY, PAGE_POLICY
from dock_gateway.http.static import CompressedFiles, is_compressed
from dock_gateway.settings import Settings

# The names of assets contain a hash of their content, so that caches may keep them indefinitely.
ASSET_HEADERS = {"Cache-Control": "public, max-age=31536000, immutable"}
FILE_HEADERS = {"Cache-Control": "no-cache"}
PAGE_HEADERS = {**FILE_HEADERS, CONTENT_SECURITY_POLICY: PAGE_POLICY}
_READ = ["GET", "HEAD"]
NOT_BUILT = """<!doctype html><html lang="en"><meta charset="utf-8"><title>dock-gateway</title>
<h1>dock-gateway is running; its dashboard has not been built</h1>
<p>In the checkout, run <code>make run</code>, or <code>make setup</code> and reload this page.
The API is available: <a href="/docs">/docs</a>.</p></html>"""


def find_dashboard(settings: Settings) -> Path | None:
    """Return the folder of the built dashboard: as configured, as installed, or as built in a checkout."""
    package = Path(__file__).resolve().parent.parent
    candidates = (settings.dashboard_dir, package / "dashboard", package.parent.parent / "frontend" / "dist")
    return next((folder for folder in candidates if folder and (folder / "index.html").is_file()), None)


def page_of(settings: Settings) -> Callable[[Request], Awaitable[Response]]:
    """Return the endpoint of the page."""
    folder = find_dashboard(settings)
    pages = CompressedFiles(folder, PAGE_HEADERS) if folder else None

    async def dashboard(request: Request) -> Response:
        if pages is None:
            return HTMLResponse(NOT_BUILT, headers=PAGE_HEADERS)
        return await pages.get_response("index.html", request.scope)

    return dashboard


def install_dashboard(app: FastAPI, settings: Settings) -> None:
    """Serve the page at `/` and `/ui/…`, and its assets. Must come after every API route."""
    folder, page = find_dashboard(settings), page_of(settings)
    for address in ("/", "/ui/{path:path}"):
        app.add_api_route(address, page, methods=_READ, include_in_schema=False)
    if folder is None:
        return
    if (folder / "assets").is_dir():
        app.mount("/assets", CompressedFiles(folder / "assets", ASSET_HEADERS))

    files = CompressedFiles(folder, FILE_HEADERS)

    async def file(request: Request) -> Response:
        return await files.get_response(request.url.path.removeprefix("/"), request.scope)

    for path in folder.iterdir():  # files next to the page, such as its icon
        if "." in path.name and path.is_file() and not is_compressed(path.name):
            app.add_api_route(f"/{path.name}", file, methods=_READ, include_in_schema=False)
