"""Each publisher has a say of its own about whether the robot stands; gateways speak as one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_io.stop_votes import StopVotes

BUTTON, SCANNER, FIRST, SECOND, RESTARTED = b"button", b"scanner", b"first", b"second", b"restarted"
NODES = {BUTTON: "/button", SCANNER: "/scanner", FIRST: "/gateway_1", SECOND: "/gateway_2"}
GATEWAYS = {"/gateway_1", "/gateway_2"}


class Topic:
    """A stop topic and who is on it."""

    def __init__(self) -> None:
        self.votes = StopVotes()
        self.there = dict(NODES)
        self._numbers = dict.fromkeys([*NODES, RESTARTED], 0)

    def says(self, publisher: bytes, latched: bool) -> bool:
        """Whether a stop holds after somebody has said something."""
        self._numbers[publisher] += 1
        self.votes.hear(publisher, self._numbers[publisher], latched=latched)
        return self.looked()

    def looked(self) -> bool:
        self.votes.update_graph(self.there, GATEWAYS)
        return self.votes.held

    def leaves(self, publisher: bytes) -> bool:
        del self.there[publisher]
        return self.looked()


@pytest.fixture
def topic() -> Topic:
    return Topic()


@given(st.lists(st.tuples(st.sampled_from([BUTTON, SCANNER, FIRST]), st.booleans())))
def test_a_stop_holds_while_one_of_them_wants_it(said: list[tuple[bytes, bool]]) -> None:
    topic = Topic()
    last: dict[bytes, bool] = {}
    for publisher, latched in said:
        last[publisher] = latched
        assert topic.says(publisher, latched) is any(last.values())


def test_no_false_releases_the_true_of_another(topic: Topic) -> None:
    assert topic.says(BUTTON, latched=True)
    assert topic.says(SCANNER, latched=False)
    assert topic.says(FIRST, latched=False)
    assert not topic.says(BUTTON, latched=False)


def test_gateways_agree_on_what_the_last_of_them_said(topic: Topic) -> None:
    assert topic.says(FIRST, latched=True)
    assert topic.says(SECOND, latched=True)
    assert not topic.says(SECOND, latched=False)
    assert not topic.leaves(FIRST)  # it withdraws what it said


def test_messages_come_twice_and_late(topic: Topic) -> None:
    topic.says(BUTTON, latched=True)
    topic.says(BUTTON, latched=False)
    topic.votes.hear(BUTTON, 1, latched=True)
    assert not topic.votes.held


def test_who_leaves_holds_the_robot_until_it_is_back(topic: Topic) -> None:
    topic.says(BUTTON, latched=True)
    assert topic.leaves(BUTTON)
    assert topic.says(SCANNER, latched=False)
    topic.there[RESTARTED] = "/button"
    assert topic.looked()  # it is there, and has said nothing yet
    assert topic.says(RESTARTED, latched=True)
    assert not topic.says(RESTARTED, latched=False)


def test_a_gateway_releases_what_one_that_left_has_stopped(topic: Topic) -> None:
    topic.says(FIRST, latched=False)
    topic.says(BUTTON, latched=True)
    assert topic.leaves(BUTTON)
    assert topic.says(FIRST, latched=True)
    assert not topic.says(FIRST, latched=False)


def test_a_gateway_that_was_killed_holds_the_robot_until_one_releases_it(topic: Topic) -> None:
    topic.says(FIRST, latched=True)
    assert topic.leaves(FIRST)
    assert topic.says(BUTTON, latched=False)
    assert not topic.says(SECOND, latched=False)


def test_a_gateway_may_release_a_stop_and_leave_before_its_name_is_known(topic: Topic) -> None:
    topic.says(FIRST, latched=True)
    for number, latched in ((1, True), (2, False)):
        topic.votes.hear(SECOND, number, latched=latched)
        topic.votes.update_graph({**NODES, SECOND: ""}, GATEWAYS, {FIRST, SECOND})
        assert topic.votes.held is latched
    assert not topic.leaves(SECOND)
    assert topic.says(FIRST, latched=True)


def test_who_keeps_what_it_said_counts_for_itself_once_its_name_is_known(topic: Topic) -> None:
    topic.votes.hear(BUTTON, 1, latched=True)
    topic.votes.update_graph({**NODES, BUTTON: ""}, GATEWAYS, {BUTTON})
    assert topic.says(FIRST, latched=False)
    topic.votes.hear(BUTTON, 2, latched=False)
    assert not topic.looked()


def test_who_is_not_known_by_name_counts_like_others() -> None:
    votes = StopVotes()
    votes.hear(BUTTON, 1, latched=True)
    votes.update_graph({BUTTON: ""}, set())
    assert votes.unknown
    votes.hear(SCANNER, 1, latched=False)
    votes.update_graph({SCANNER: ""}, set())  # it left before its name came
    assert votes.held
    votes.hear(FIRST, 1, latched=False)
    votes.update_graph({FIRST: "/gateway_1"}, GATEWAYS)
    assert not votes.held
