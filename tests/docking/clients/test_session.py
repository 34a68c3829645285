import pytest

from docking.clients.session import ExitCode, Patience, Phase, Request, Session

PATIENCE = Patience(server=10.0, acceptance=5.0, silence=3.0, lost=10.0, cancel=5.0, ping_period=0.5)


@pytest.fixture
def session() -> Session:
    return Session(PATIENCE, 0.0)


@pytest.fixture
def sent(session: Session) -> Session:
    session.heard(1.0)
    assert session.step(1.0) is Request.SEND_GOAL
    return session


@pytest.fixture
def running(sent: Session) -> Session:
    sent.answered(accepted=True, now=1.0)
    return sent


def test_a_server_is_pinged_until_it_answers(session: Session) -> None:
    assert [session.step(now) for now in (0.0, 0.2, 0.4, 0.6)] == [Request.PING, None, None, Request.PING]
    session.heard(0.7)
    assert session.step(0.7) is Request.SEND_GOAL
    assert session.phase is Phase.SENT


def test_without_a_server_it_ends(session: Session) -> None:
    session.step(9.9)
    assert session.exit_code is None
    session.step(10.0)
    assert session.exit_code is ExitCode.NO_SERVER


def test_a_rejected_goal_ends_it(sent: Session) -> None:
    sent.answered(accepted=False, now=1.1)
    assert sent.exit_code is ExitCode.REJECTED


def test_a_goal_without_an_answer_is_canceled_and_given_up(sent: Session) -> None:
    assert sent.step(5.9) is None
    assert sent.step(6.0) is Request.CANCEL_GOAL
    assert sent.exit_code is ExitCode.NO_SERVER
    assert sent.step(7.0) is None
    sent.answered(accepted=True, now=7.0)
    assert sent.phase is Phase.OVER


@pytest.mark.parametrize(
    ("status", "exit_code"),
    [
        (4, ExitCode.SUCCEEDED),
        (5, ExitCode.CANCELED),
        (6, ExitCode.ABORTED),
        (0, ExitCode.LOST),
    ],
)
def test_the_result_gives_the_exit_code(running: Session, status: int, exit_code: ExitCode) -> None:
    running.ended(status)
    assert running.exit_code is exit_code
    assert running.explanation


def test_a_result_before_the_acceptance_is_ignored(sent: Session) -> None:
    sent.ended(4)
    assert sent.exit_code is None


def test_a_silent_server_is_pinged_and_then_lost(running: Session) -> None:
    assert running.step(3.9) is None
    assert running.step(4.0) is Request.PING
    assert running.step(10.9) is Request.PING
    running.step(11.0)
    assert running.exit_code is ExitCode.LOST


def test_a_server_that_answers_pings_is_not_lost(running: Session) -> None:
    for second in range(4, 100):
        running.step(float(second))
        running.heard(float(second))
    assert running.exit_code is None


def test_ctrl_c_cancels_once_and_waits_for_the_end(running: Session) -> None:
    running.interrupt()
    assert [running.step(2.0), running.step(2.1)] == [Request.CANCEL_GOAL, None]
    running.ended(5)
    assert running.exit_code is ExitCode.INTERRUPTED


def test_a_goal_that_succeeds_in_spite_of_ctrl_c_has_succeeded(running: Session) -> None:
    running.interrupt()
    running.ended(4)
    assert running.exit_code is ExitCode.SUCCEEDED


def test_a_cancel_that_does_not_end_the_goal_has_a_deadline(running: Session) -> None:
    running.interrupt()
    running.step(2.0)
    running.heard(6.9)
    assert running.step(6.9) is None
    running.step(7.0)
    assert running.exit_code is ExitCode.LOST


def test_a_refused_cancel_leaves_the_goal_running(running: Session) -> None:
    running.interrupt()
    running.step(2.0)
    running.cancel_refused()
    running.heard(50.0)
    assert running.step(50.0) is None
    assert running.exit_code is None


def test_the_second_ctrl_c_leaves_at_once(running: Session) -> None:
    running.interrupt()
    running.step(2.0)
    running.interrupt()
    running.step(2.1)
    assert running.exit_code is ExitCode.INTERRUPTED


def test_ctrl_c_before_the_goal_is_sent_sends_none(session: Session) -> None:
    session.interrupt()
    session.heard(0.1)
    assert session.step(0.1) is None
    assert session.exit_code is ExitCode.INTERRUPTED


def test_ctrl_c_before_the_answer_cancels_after_it(sent: Session) -> None:
    sent.interrupt()
    assert sent.step(1.5) is None
    sent.answered(accepted=True, now=2.0)
    assert sent.step(2.0) is Request.CANCEL_GOAL


def test_ctrl_c_twice_before_the_answer_leaves_and_cancels(sent: Session) -> None:
    sent.interrupt()
    sent.interrupt()
    assert sent.step(1.5) is Request.CANCEL_GOAL
    assert sent.exit_code is ExitCode.INTERRUPTED
