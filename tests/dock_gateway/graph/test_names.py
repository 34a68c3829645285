"""Hints at similar names."""

import difflib
from typing import Any

import pytest

from dock_gateway.graph.names import MAX_COMPARED, not_found

PARTS = ("dock_server/get_parameters", "dock_server/set_parameters", "dock_server/get_state", "simulator/reset")
FLEET = [f"/robot{number}/{part}" for number in range(50) for part in PARTS]


@pytest.mark.parametrize(
    "name",
    ["/robot7/dock_server/get_parameter", "/robot7/dock_servr/get_parameters", "/robt7/dock_server/get_parameters"],
)
def test_the_most_similar_name_of_a_fleet_is_found(name: str) -> None:
    assert "did you mean /robot7/dock_server/get_parameters" in not_found("service", name, FLEET).detail


def test_nothing_is_like_it() -> None:
    assert not_found("topic", "/x", FLEET).detail == "there is no topic /x on the ROS graph"


def test_a_hint_does_not_compare_a_fleet(monkeypatch: pytest.MonkeyPatch) -> None:
    compared: list[str] = []

    def close(_: str, names: list[str], **__: Any) -> list[str]:
        compared.extend(names)
        return []

    monkeypatch.setattr(difflib, "get_close_matches", close)
    not_found("service", "/robot7/dock_server/get_parameter", FLEET)
    assert len(compared) <= MAX_COMPARED
