"""A flood of lines is cut short and says so; other lines are not affected."""

import logging

import pytest

from dock_gateway.core.log_limit import MAX_KINDS, MAX_LINES, PERIOD, LogLimit


class Log:
    """A logger of its own; the clock is `seconds`."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.lines: list[str] = []
        handler = logging.Handler()
        handler.emit = lambda record: self.lines.append(record.getMessage())  # type: ignore[method-assign]
        self.limit = LogLimit(lambda: self.seconds)
        handler.addFilter(self.limit)
        self.logger = logging.Logger("limited")
        self.logger.addHandler(handler)

    def take(self) -> list[str]:
        lines, self.lines = self.lines, []
        return lines


@pytest.fixture
def log() -> Log:
    return Log()


def test_a_flood_is_cut_short_and_counted(log: Log) -> None:
    for number in range(1000):
        log.logger.info("goal %s", number)
    lines = log.take()
    assert lines[:2] == ["goal 0", "goal 1"]
    assert lines[MAX_LINES - 1 :] == [f"goal {MAX_LINES - 1} (similar lines are suppressed for 10 s)"]
    log.seconds += PERIOD
    for number in range(2):
        log.logger.info("goal %s", number)
    assert log.take() == [f"goal 0 ({1000 - MAX_LINES} similar lines were suppressed)", "goal 1"]
    log.seconds += PERIOD
    log.logger.info("goal %s", 5)
    assert log.take() == ["goal 5"]


def test_other_lines_are_written(log: Log) -> None:
    for _ in range(100):
        log.logger.info("noise")
    log.take()
    log.logger.warning("a stop of %s is latched", "/robot1")
    assert log.take() == ["a stop of /robot1 is latched"]


def test_any_number_of_kinds_takes_little_memory(log: Log) -> None:
    for number in range(3 * MAX_KINDS):
        log.logger.info(f"line {number}")
    assert len(log.take()) == 3 * MAX_KINDS
    assert log.limit.kinds <= MAX_KINDS


def test_arguments_that_do_not_fit_harm_nobody(log: Log) -> None:
    record = logging.LogRecord("limited", logging.INFO, "", 1, "%s of %s", ("one",), None)
    limit = LogLimit(lambda: 0.0)
    assert [limit.filter(record) for _ in range(MAX_LINES + 1)] == [True] * MAX_LINES + [False]
