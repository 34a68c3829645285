"""What lies in a namespace."""

import pytest

from dock_gateway.core.filters import is_hidden, is_under, lineage, prefix_of


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


@pytest.mark.parametrize(
    ("name", "namespaces"),
    [("/", ["/"]), ("/a", ["/", "/a"]), ("/fleet/robot1/dock", ["/", "/fleet", "/fleet/robot1", "/fleet/robot1/dock"])],
)
def test_the_namespaces_that_a_name_is_in(name: str, namespaces: list[str]) -> None:
    assert list(lineage(name)) == namespaces


@pytest.mark.parametrize(
    ("name", "within", "hidden"),
    [
        ("/robot2/dock", "/", False),
        ("/robot_2/dock_", "/", False),
        ("/robot2/a__b", "/", False),
        ("/_robot2", "/", True),
        ("/robot2/_do_not_use/dock", "/", True),
        ("/robot2/_dock", "/", True),
        ("/robot2/_private/dock", "/robot2/_private", False),
        ("/robot2/_private/dock", "/robot2/_private/", False),
        ("/robot2/_private/_dock", "/robot2/_private", True),
        ("/robot2/_private_too/dock", "/robot2/_private", True),
        ("/", "/_private", False),
    ],
)
def test_hidden_names(name: str, within: str, hidden: bool) -> None:
    assert is_hidden(name, within) is hidden
