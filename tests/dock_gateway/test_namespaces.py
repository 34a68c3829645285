"""What lies in a namespace."""

import pytest

from dock_gateway.namespaces import is_under, prefix_of


@pytest.mark.parametrize(
    ("name", "namespace", "under"),
    [
        ("/", "/", True),
        ("/robot1", "/", True),
        ("/connect_to_charging_dock", "/", True),
        ("/robot1/dock", "/robot1", True),
        ("/robot1", "/robot1", True),
        ("/robot10/dock", "/robot1", False),
        ("/dock", "/robot1", False),
        ("/", "/robot1", False),
    ],
)
def test_what_is_in_a_namespace(name: str, namespace: str, under: bool) -> None:
    assert is_under(name, namespace) is under


@pytest.mark.parametrize(("namespace", "prefix"), [("/", "/"), ("", "/"), ("/robot1", "/robot1/"), ("/a/b/", "/a/b/")])
def test_what_names_in_it_begin_with(namespace: str, prefix: str) -> None:
    assert prefix_of(namespace) == prefix
