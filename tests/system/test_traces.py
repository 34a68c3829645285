"""The traces in docs/architecture.md are those of a real request."""

from scripts.traces import PAGE, written


def test_the_traces_are_those_of_the_code() -> None:
    page = PAGE.read_text()
    assert written(page) == page, "renew the traces: make traces"
