"""The OpenAPI document, which takes a second to make."""

from typing import Any

import orjson
import pytest

from dock_gateway.app import create_app
from dock_gateway.settings import Settings


@pytest.fixture(scope="session")
def document_bytes() -> bytes:
    return orjson.dumps(create_app(Settings()).openapi())


@pytest.fixture
def document(document_bytes: bytes) -> dict[str, Any]:
    """A copy that the test may change."""
    document: dict[str, Any] = orjson.loads(document_bytes)
    return document
