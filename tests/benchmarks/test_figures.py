"""A figure is the median of its turns; what was left out has a reason and no figure."""

from benchmarks.figures import BARE, OURS, Results
from benchmarks.table import table

CASE, PEER = "(b) 100 Hz", "a peer"


def test_figure_is_the_median_of_its_turns_with_their_spread() -> None:
    results = Results()
    for value in (3.0, 1.0, 20.0):
        results.add(CASE, "p50", OURS, value)
    figure = results.find(CASE, "p50", OURS)
    assert figure is not None
    assert (figure.value, figure.spread) == (3.0, (1.0, 20.0))
    assert "3.00 ms (1.00 to 20.00)" in table(results)


def test_table_compares_the_gateway_with_the_bare_client_and_with_each_variant() -> None:
    results = Results()
    for system, value in ((PEER, 9.0), (f"{OURS} before", 3.0), (OURS, 6.0), (BARE, 2.0)):
        results.add(CASE, "p50", system, value)
    assert results.systems() == [BARE, OURS, f"{OURS} before", PEER]
    head, _, row = (line.split("|") for line in table(results).splitlines()[:3])
    columns = {name.strip(): cell.strip() for name, cell in zip(head, row, strict=True)}
    assert (columns[f"÷ {BARE}"], columns[f"÷ {OURS} before"]) == ("3.00", "2.00")


def test_table_says_why_a_system_was_left_out() -> None:
    results = Results()
    results.add(CASE, "p50", OURS, 1.0)
    results.leave_out(PEER, "", "it did not start")
    results.leave_out(OURS, CASE, "TimeoutError")
    text = table(results)
    assert f"- left out: {PEER}: it did not start" in text
    assert f"- left out: {OURS}, {CASE} (1 of 2 turns): TimeoutError" in text
    assert PEER not in text.splitlines()[0]


def test_document_holds_each_turn_and_the_ratio_to_the_bare_client() -> None:
    results = Results()
    for system, value in ((BARE, 2.0), (OURS, 3.0), (OURS, 5.0)):
        results.add(CASE, "p50", system, value)
    results.leave_out(PEER, "", "it did not start")
    assert results.document() == {
        "figures": [
            {"case": CASE, "measure": "p50", "system": BARE, "unit": "ms"}
            | {"turns": [2.0], "median": 2.0, "ratio_to_bare": 1.0},
            {"case": CASE, "measure": "p50", "system": OURS, "unit": "ms"}
            | {"turns": [3.0, 5.0], "median": 4.0, "ratio_to_bare": 2.0},
        ],
        "left_out": [{"system": PEER, "case": "", "reasons": ["it did not start"]}],
    }
