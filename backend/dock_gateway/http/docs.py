"""`/docs`: the API in a browser. The gateway serves all files, since robots are often offline."""

from importlib.resources import files
from pathlib import Path

from fastapi import FastAPI
from starlette.middleware.gzip import GZipMiddleware
from starlette.responses import HTMLResponse, Response

from dock_gateway.http.edge.security import CONTENT_SECURITY_POLICY, PAGE_POLICY
from dock_gateway.http.static import CompressedFiles

NO_CACHE = {"Cache-Control": "no-cache"}

# The script is a separate file: the content security policy forbids inline scripts.
SCRIPT = """SwaggerUIBundle({
  url: "openapi.json", dom_id: "#swagger-ui", deepLinking: true, filter: true, tryItOutEnabled: true,
  displayRequestDuration: true, validatorUrl: null, presets: [SwaggerUIBundle.presets.apis]
})"""
PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>dock-gateway API</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="stylesheet" href="swagger/swagger-ui.css"><link rel="icon" href="swagger/favicon-32x32.png"></head>
<body><div id="swagger-ui"></div>
<script src="swagger/swagger-ui-bundle.js"></script><script src="docs/start.js"></script></body></html>"""


def install_docs(app: FastAPI) -> None:
    """Serve the page and its files."""

    @app.get("/docs", include_in_schema=False)
    async def docs() -> Response:
        return HTMLResponse(PAGE, headers={CONTENT_SECURITY_POLICY: PAGE_POLICY, **NO_CACHE})

    @app.get("/docs/start.js", include_in_schema=False)
    async def start() -> Response:
        return Response(SCRIPT, media_type="text/javascript", headers=NO_CACHE)

    folder = Path(str(files("fastapi_swagger"))) / "resources"
    app.mount("/swagger", GZipMiddleware(CompressedFiles(folder, NO_CACHE)))
