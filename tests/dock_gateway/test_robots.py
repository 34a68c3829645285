"""Namespaces as clients may write them."""

import pytest

from dock_gateway.errors import InvalidField
from dock_gateway.robots import normalize_namespace, read_namespace


@pytest.mark.parametrize(("text", "namespace"), [("", "/"), ("/", "/"), ("robot1", "/robot1"), ("/a/b/", "/a/b")])
def test_settings_are_generous(text: str, namespace: str) -> None:
    assert normalize_namespace(text) == namespace


@pytest.mark.parametrize(("text", "namespace"), [("/", "/"), ("/robot1", "/robot1"), ("/fleet/r_2/", "/fleet/r_2")])
def test_clients_name_a_namespace(text: str, namespace: str) -> None:
    assert read_namespace(text) == namespace


@pytest.mark.parametrize("text", ["", "robot1", "/robot 1", "/1robot", "/a//b", "/a/../b", "/röbot", "/a\0"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(InvalidField):
        read_namespace(text)
