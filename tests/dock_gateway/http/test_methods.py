"""`OPTIONS` and 405 name the methods that a path has, as OpenAPI lists them."""

import re
from typing import Any

import pytest
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.settings import Settings

METHODS = {"get", "put", "post", "delete"}


@pytest.fixture
def client() -> TestClient:
    return TestClient(create_app(Settings()), base_url="http://127.0.0.1:8000")


def example(path: str) -> str:
    return re.sub(r"{[^}]+}", "x", path.replace("{goal_id}", "7d9c1c9e-0000-4000-8000-000000000000"))


def read(allow: str) -> set[str]:
    return {method.strip().lower() for method in allow.split(",")}


def test_each_path_names_its_methods(client: TestClient, document: dict[str, Any]) -> None:
    for path, operations in document["paths"].items():
        options, other = client.options(example(path)), client.patch(example(path))
        assert (options.status_code, options.content) == (204, b""), path
        assert (other.status_code, other.json()["code"]) == (405, "method_not_allowed"), path
        for response in (options, other):
            assert read(response.headers["allow"]) == {"options", *(METHODS & operations.keys())}, path


def test_pages_and_what_is_not_there(client: TestClient) -> None:
    assert read(client.options("/").headers["allow"]) == {"get", "head", "options"}
    assert read(client.put("/docs").headers["allow"]) == {"get", "options"}
    for method in ("OPTIONS", "DELETE"):
        response = client.request(method, "/nothing")
        assert (response.status_code, response.json()["code"]) == (404, "not_found")


def test_a_request_that_is_no_preflight_of_an_allowed_page() -> None:
    client = TestClient(create_app(Settings(allowed_origins="https://ops.example")), base_url="http://127.0.0.1:8000")  # type: ignore[arg-type]
    response = client.options("/dock", headers={"Origin": "https://ops.example"})
    assert response.status_code == 204
    assert read(response.headers["allow"]) == {"get", "post", "options"}
    assert response.headers["access-control-allow-origin"] == "https://ops.example"
