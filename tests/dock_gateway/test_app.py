"""The application as a browser page of another origin meets it: allowed pages may use all of it, others nothing."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcp.server import streamable_http
from mcp.shared import inbound
from starlette.testclient import TestClient

import dock_gateway
from dock_gateway.app import create_app
from dock_gateway.http import request_id
from dock_gateway.settings import Settings

PACKAGE = Path(dock_gateway.__file__).parent
OPS = "https://ops.example"


def client(allowed_origins: str) -> TestClient:
    settings = Settings(allowed_origins=allowed_origins)  # type: ignore[arg-type]
    return TestClient(create_app(settings), base_url="http://127.0.0.1:8000")


def preflight(origin: str, method: str, **more: str) -> dict[str, str]:
    return {
        "Origin": origin,
        "Access-Control-Request-Method": method,
        "Access-Control-Request-Headers": "content-type,idempotency-key",
        **more,
    }


@pytest.mark.parametrize("allowed", [OPS, f"https://a.example,{OPS}", "HTTPS://Ops.Example"])
@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "DELETE"])
def test_a_preflight_of_an_allowed_page(allowed: str, method: str) -> None:
    more = {"Access-Control-Request-Private-Network": "true"}
    response = client(allowed).options("/dock", headers=preflight(OPS, method, **more))
    assert response.status_code == 200
    assert response.headers["access-control-allow-origin"] == OPS
    assert method in response.headers["access-control-allow-methods"]
    assert response.headers["access-control-allow-private-network"] == "true"


@pytest.mark.parametrize("allowed", ["", "https://other.example"])
def test_a_preflight_of_any_other_page(allowed: str) -> None:
    response = client(allowed).options("/dock", headers=preflight(OPS, "POST"))
    assert (response.status_code, response.json()["code"]) == (403, "origin_not_allowed")
    assert "access-control-allow-origin" not in response.headers


def test_a_preflight_to_a_foreign_name() -> None:
    response = client(OPS).options("/dock", headers=preflight(OPS, "POST", Host="evil.example"))
    assert (response.status_code, response.json()["code"]) == (403, "host_not_allowed")


TOKEN = "abcdefghijklmnopqrstuvwxyz0123456789!#$%&'*+-.^_`|~"  # RFC 9110, 5.6.2; browsers send names in lower case
APP = client(OPS)


def headers_that_are_read() -> set[str]:
    """Those of the OpenAPI document, those that the code names, and those of the Model Context Protocol."""
    document = APP.get("/openapi.json").json()
    operations = [operation for path in document["paths"].values() for operation in path.values()]
    parameters = [parameter for operation in operations for parameter in operation.get("parameters", ())]
    code = "".join(path.read_text() for path in PACKAGE.rglob("*.py"))
    agents = {inbound.MCP_PROTOCOL_VERSION_HEADER, inbound.MCP_METHOD_HEADER, inbound.MCP_NAME_HEADER}
    return {
        *(parameter["name"] for parameter in parameters if parameter["in"] == "header"),
        *re.findall(r"\.headers(?:\.get\(|\[)\"([\w-]+)\"", code),
        *request_id.TRACE,
        *agents,
        streamable_http.MCP_SESSION_ID_HEADER,
        f"{inbound.MCP_PARAM_HEADER_PREFIX}robot",
    }


def test_an_allowed_page_may_send_every_header_that_is_read() -> None:
    names = {name.lower() for name in headers_that_are_read()}
    assert {"idempotency-key", "prefer", "if-none-match", "last-event-id", "traceparent", "mcp-session-id"} < names
    asked = {"Access-Control-Request-Headers": ",".join(sorted(names))}
    response = APP.options("/mcp", headers=preflight(OPS, "POST", **asked))
    assert response.status_code == 200, response.text
    assert names == set(re.split(", ?", response.headers["access-control-allow-headers"].lower()))


@given(st.sets(st.text(TOKEN, min_size=1, max_size=30), min_size=1, max_size=10))
def test_an_allowed_page_may_send_any_header(names: set[str]) -> None:
    asked = {"Access-Control-Request-Headers": ",".join(sorted(names))}
    response = APP.options("/dock", headers=preflight(OPS, "POST", **asked))
    assert response.status_code == 200, response.text
    assert names <= {name.strip() for name in response.headers["access-control-allow-headers"].split(",")}
    assert APP.options("/dock", headers=preflight("https://evil.example", "POST", **asked)).status_code == 403


def test_what_an_allowed_page_may_read() -> None:
    """All of it. `*` means every header, as no answer to a page of another origin depends on its cookies."""
    headers = APP.get("/openapi.json", headers={"Origin": OPS}).headers
    assert headers["access-control-allow-origin"] == OPS
    assert headers["access-control-expose-headers"] == "*"
    assert "access-control-allow-credentials" not in headers
    assert client("*").get("/openapi.json", headers={"Origin": OPS}).headers["access-control-allow-origin"] == "*"
    assert "access-control-allow-origin" not in client("").get("/openapi.json", headers={"Origin": OPS}).headers
