"""How many unknown goals a node may bring up."""

from dataclasses import dataclass, field

from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.ros.admission import CHECK_INTERVAL, MAX_PUBLISHERS, MAX_UNKNOWN, RECENT, WINDOW, Admission
from dock_gateway.ros.status import text_of

SERVER, FLOOD = b"server", b"flood"


@dataclass
class Known:
    """Goals by their text."""

    tracked: set[str] = field(default_factory=set)
    over: set[str] = field(default_factory=set)

    def tracks(self, goal_id: str) -> bool:
        return goal_id in self.tracked

    def ended(self, goal_id: str) -> bool:
        return goal_id in self.over


class Scene:
    def __init__(self) -> None:
        self.known = Known()
        self.now = 0.0
        self.told: list[bytes] = []
        self.admission = Admission(self.known, self.told.append, lambda: self.now)

    def fill(self, publisher: bytes, count: int = MAX_UNKNOWN) -> None:
        assert all(self.admission.of_feedback(publisher, new(number)) for number in range(count))


def new(number: int) -> bytes:
    return number.to_bytes(16, "big")


def test_beyond_the_limit_unknown_goals_are_ignored_counted_and_told_once() -> None:
    scene = Scene()
    scene.fill(FLOOD)
    for number in range(100, 200):
        assert not scene.admission.of_feedback(FLOOD, new(number))
        assert not scene.admission.of_status(FLOOD, new(number))
    assert scene.admission.ignored == 200
    assert scene.told == [FLOOD]
    assert scene.admission.exceeded
    scene.now = RECENT + 1
    assert not scene.admission.exceeded


def test_goals_that_are_known_come_through() -> None:
    scene = Scene()
    scene.fill(FLOOD)
    scene.known.tracked.add(text_of(new(1000)))
    assert scene.admission.of_feedback(FLOOD, new(1000))
    assert scene.admission.of_status(FLOOD, new(1000))
    assert scene.admission.of_feedback(FLOOD, new(1)), "it was let through before, and is on its way"
    assert scene.admission.ignored == 0


def test_a_flood_does_not_keep_the_goals_of_others_from_being_found() -> None:
    scene = Scene()
    scene.fill(FLOOD)
    assert not scene.admission.of_status(FLOOD, new(1000))
    assert scene.admission.of_status(SERVER, new(1000))


def test_feedback_of_a_goal_that_has_ended_is_not_read_but_its_status_is() -> None:
    scene = Scene()
    scene.known.over.add(text_of(new(1)))
    assert not scene.admission.of_feedback(SERVER, new(1))
    assert scene.admission.of_status(SERVER, new(1))
    assert scene.admission.ignored == 0


def test_goals_that_end_make_room_at_once_and_others_after_a_while() -> None:
    scene = Scene()
    for number in range(10 * MAX_UNKNOWN):
        if number % MAX_UNKNOWN == 0:
            scene.now += 2 * CHECK_INTERVAL
        assert scene.admission.of_status(SERVER, new(number)), "a server may have any number of short goals"
        scene.known.over.add(text_of(new(number)))
    scene.known.over.clear()
    scene.fill(FLOOD)
    assert not scene.admission.of_status(FLOOD, new(1000))
    scene.now += WINDOW
    assert scene.admission.of_status(FLOOD, new(1000))


@given(st.lists(st.tuples(st.integers(0, 3 * MAX_PUBLISHERS), st.integers(0, 10_000), st.floats(0, 0.2)), max_size=300))
def test_however_many_nodes_make_up_goals_few_are_let_through(messages: list[tuple[int, int, float]]) -> None:
    scene = Scene()
    let_through: set[tuple[int, int]] = set()
    for publisher, number, pause in messages:
        scene.now = min(scene.now + pause, WINDOW * 0.9)
        if scene.admission.of_feedback(b"%d" % publisher, new(number)):
            let_through.add((publisher, number))
    assert len(let_through) <= (MAX_PUBLISHERS + 1) * MAX_UNKNOWN


def test_publishers_that_come_and_go_share_a_limit_until_one_is_idle() -> None:
    scene = Scene()
    let_through = sum(
        scene.admission.of_feedback(b"%d" % (number // 10), new(number)) for number in range(100 * MAX_PUBLISHERS)
    )
    assert let_through == MAX_PUBLISHERS * 10 + MAX_UNKNOWN
    scene.now = WINDOW + 1
    assert scene.admission.of_feedback(b"another", new(5000))
