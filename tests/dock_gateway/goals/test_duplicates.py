"""When a second server is one that lives, and not one that was killed and is still on the graph."""

import pytest

from dock_gateway.goals.duplicates import SETTLED, Duplicates
from dock_gateway.ros.action_link import ServerPresence


class Watch:
    """Looks at servers at a number of seconds."""

    def __init__(self) -> None:
        self._duplicates = Duplicates()
        self.answered_twice_at = float("-inf")

    def found(self, seconds: float, *servers: str) -> bool:
        return self._duplicates.found(ServerPresence(True, frozenset(servers), self.answered_twice_at), seconds)


@pytest.fixture
def watch() -> Watch:
    return Watch()


def test_one_server(watch: Watch) -> None:
    assert not watch.found(0)
    assert not watch.found(1000, "a")


def test_two_that_answer_are_found_at_once(watch: Watch) -> None:
    assert not watch.found(0, "a", "b")
    watch.answered_twice_at = 0.5
    assert watch.found(1, "a", "b")
    assert not watch.found(2), "one has left"


def test_a_killed_server_and_its_successor_are_not_two(watch: Watch) -> None:
    assert not watch.found(0, "dead", "new")
    assert not watch.found(20, "dead", "new")
    assert not watch.found(21)


def test_servers_that_die_again_and_again_are_not_two(watch: Watch) -> None:
    for second in range(100):
        alive = [f"server{start}" for start in range(0, second + 1, 5) if second - start < 25]
        assert not watch.found(second, *alive)


def test_two_that_stay_are_found_though_they_do_not_answer(watch: Watch) -> None:
    assert not watch.found(0, "a", "b")
    assert not watch.found(SETTLED, "a", "b")
    assert watch.found(SETTLED + 1, "a", "b")


def test_one_that_was_killed_after_it_had_answered_is_forgotten(watch: Watch) -> None:
    watch.answered_twice_at = 0.0
    assert watch.found(1, "a", "b")
    assert watch.found(15, "a", "b")
    assert not watch.found(20)
