"""Who is welcome under the name of a site, whatever claims it."""

from uuid import UUID

from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.sites.messages import Hello, Refusal, Welcome
from dock_hub.directory import SILENT_AFTER, Directory, SiteState

OURS, THEIRS = (UUID(int=number) for number in (1, 2))
FIRST, SECOND, THIRD = (f"{number:016x}" for number in (1, 2, 3))


def hello(
    instance: str = FIRST,
    installation: UUID = OURS,
    *,
    version: str = "0.7.1",
    leaving: bool = False,
    at: float = 1000.0,
) -> Hello:
    return Hello(installation=installation, instance=instance, version=version, at=at, leaving=leaving)


def code_of(answer: Welcome | Refusal) -> str:
    return "" if isinstance(answer, Welcome) else answer.code


def test_a_taken_name_is_refused_until_the_site_is_forgotten() -> None:
    directory = Directory("0.7.0", {"berlin": str(OURS)})
    assert code_of(directory.judge("berlin", hello(SECOND, THEIRS), 0, 1000)) == "site_name_taken"
    assert directory.sites["berlin"].state(1) is SiteState.REFUSED
    assert code_of(directory.judge("berlin", hello(), 1, 1001)) == ""
    assert directory.forget("berlin")
    assert code_of(directory.judge("berlin", hello(SECOND, THEIRS), 2, 1002)) == ""


def test_releases_one_apart_work_together() -> None:
    directory = Directory("0.8.0", {})
    answers = {each: code_of(directory.judge("berlin", hello(version=each), 0, 0)) for each in ("0.7.9", "0.9.0")}
    assert set(answers.values()) == {""}
    for version in ("0.6.0", "0.10.0", "1.8.0", "new"):
        assert code_of(directory.judge("berlin", hello(version=version), 0, 0)) == "version_refused"
    assert directory.sites["berlin"].refused == {"version_refused": 4}


def test_a_process_that_has_left_makes_room_at_once_and_one_that_was_killed_after_a_while() -> None:
    directory = Directory("0.7.0", {})
    directory.judge("berlin", hello(FIRST), 0, 0)
    assert code_of(directory.judge("berlin", hello(SECOND), 3, 3)) == "site_connected_elsewhere"
    assert code_of(directory.judge("berlin", hello(SECOND), SILENT_AFTER, 0)) == ""
    directory.judge("berlin", hello(SECOND, leaving=True), SILENT_AFTER + 1, 0)
    assert directory.welcome_instance("berlin", SILENT_AFTER + 1) is None
    assert code_of(directory.judge("berlin", hello(THIRD), SILENT_AFTER + 1, 0)) == ""


def test_the_clocks_may_be_an_hour_apart() -> None:
    directory = Directory("0.7.0", {})
    directory.judge("berlin", hello(at=4600.0), 0, 1000.0)
    assert directory.sites["berlin"].clock_offset == 3600.0
    directory.judge("berlin", hello(at=4603.0), 3, 1009.0)  # it took 6 s
    assert directory.sites["berlin"].clock_offset == 3600.0
    directory.judge("berlin", hello(at=1012.0), 6, 1012.0)  # the clock was set
    assert directory.sites["berlin"].clock_offset == 0.0


steps = st.tuples(
    st.sampled_from([FIRST, SECOND, THIRD]),
    st.sampled_from([OURS, THEIRS]),
    st.sampled_from(["0.7.0", "0.7.0", "0.9.0"]),
    st.booleans(),
    st.floats(0, 2 * SILENT_AFTER),
    st.floats(-7200, 7200),
)


@given(st.lists(steps, max_size=30), st.booleans())
def test_never_two_at_once_and_a_name_is_never_given_away(steps: list[tuple], pinned: bool) -> None:  # type: ignore[type-arg]
    directory = Directory("0.7.0", {"berlin": str(OURS)} if pinned else {})
    now, owner = 0.0, str(OURS) if pinned else None
    last_heard: dict[str, float] = {}
    for instance, installation, version, leaving, pause, at in steps:
        now += pause
        before = directory.welcome_instance("berlin", now)
        answer = directory.judge(
            "berlin", hello(instance, installation, version=version, leaving=leaving, at=at), now, 0
        )
        if isinstance(answer, Refusal):
            assert directory.welcome_instance("berlin", now) == before
            if installation is OURS and owner == str(OURS) and version == "0.7.0":
                assert before not in (None, instance)  # only for another one that is there
                assert now - last_heard[before] < SILENT_AFTER
            continue
        assert owner in (None, str(installation))
        assert before in (None, instance)
        assert leaving or directory.welcome_instance("berlin", now) == instance
        if not leaving:
            owner = str(installation)
            last_heard[instance] = now
