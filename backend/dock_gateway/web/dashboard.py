"""The dashboard's files. API paths never return HTML, and pages never shadow API paths."""

from functools import partial
from pathlib import Path

from fastapi import FastAPI
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, Response
from starlette.staticfiles import StaticFiles

from dock_gateway.settings import Settings
from dock_gateway.web.edge.security import CONTENT_SECURITY_POLICY, PAGE_POLICY

PAGE_HEADERS = {"Cache-Control": "no-cache", CONTENT_SECURITY_POLICY: PAGE_POLICY}
NOT_BUILT = """<!doctype html><html lang="en"><meta charset="utf-8"><title>dock-gateway</title>
<h1>dock-gateway is running; its dashboard has not been built</h1>
<p>In the checkout, run <code>make run</code>, or <code>make setup</code> and reload this page.
The API is available: <a href="/docs">/docs</a>.</p></html>"""


class Assets(StaticFiles):
    """Files whose names contain a hash of their content, so that caches may keep them indefinitely."""

    def file_response(self, *args: object, **kwargs: object) -> Response:
        """Add the `Cache-Control` header."""
        response = super().file_response(*args, **kwargs)  # type: ignore[arg-type]
        response.headers["Cache-Control"] = "public, max-age=31536000, immutable"
        return response


def find_dashboard(settings: Settings) -> Path | None:
    """Return the folder of the built dashboard: as configured, as installed, or as built in a checkout."""
    package = Path(__file__).resolve().parent.parent
    candidates = (settings.dashboard_dir, package / "dashboard", package.parent.parent / "frontend" / "dist")
    return next((folder for folder in candidates if folder and (folder / "index.html").is_file()), None)


def install_dashboard(app: FastAPI, settings: Settings) -> None:
    """Serve the page at `/` and `/ui/…`, and its assets. Must come after every API route."""
    folder = find_dashboard(settings)
    files = [path for path in folder.iterdir() if "." in path.name and path.is_file()] if folder else []

    def page() -> Response:
        if folder is None:
            return HTMLResponse(NOT_BUILT, headers=PAGE_HEADERS)
        return FileResponse(folder / "index.html", headers=PAGE_HEADERS)

    @app.get("/", include_in_schema=False)
    @app.get("/ui/{path:path}", include_in_schema=False)
    async def dashboard(request: Request) -> Response:
        return page()

    if folder is not None and (folder / "assets").is_dir():
        app.mount("/assets", Assets(directory=folder / "assets"))

    for path in files:  # files next to the page, such as its icon
        app.add_api_route(f"/{path.name}", partial(_file, path), include_in_schema=False)


async def _file(path: Path) -> Response:
    return FileResponse(path, headers={"Cache-Control": "no-cache"})
