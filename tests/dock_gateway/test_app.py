"""The application as a browser page of another origin meets it: allowed pages may use all of it, others nothing."""

import pytest
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.settings import Settings

OPS = "https://ops.example"


def client(allowed_origins: str) -> TestClient:
    settings = Settings(allowed_origins=allowed_origins)  # type: ignore[arg-type]
    return TestClient(create_app(settings), base_url="http://127.0.0.1:8000")


def preflight(origin: str, method: str, **more: str) -> dict[str, str]:
    return {
        "Origin": origin,
        "Access-Control-Request-Method": method,
        "Access-Control-Request-Headers": "content-type,idempotency-key,if-none-match,last-event-id,prefer",
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


def test_what_an_allowed_page_may_read() -> None:
    headers = client(OPS).get("/openapi.json", headers={"Origin": OPS}).headers
    assert headers["access-control-allow-origin"] == OPS
    exposed = "Accept-Ranges, Content-Disposition, Content-Range, ETag, Location, Retry-After, X-Request-ID"
    assert headers["access-control-expose-headers"] == exposed
    assert client("*").get("/openapi.json", headers={"Origin": OPS}).headers["access-control-allow-origin"] == "*"
    assert "access-control-allow-origin" not in client("").get("/openapi.json", headers={"Origin": OPS}).headers
