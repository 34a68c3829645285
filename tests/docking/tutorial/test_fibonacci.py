import pytest

from docking.tutorial.fibonacci import MAX_ORDER, Fibonacci, check_order


def run(order: int) -> list[int]:
    fibonacci = Fibonacci(order)
    while not fibonacci.complete:
        fibonacci.step()
    return fibonacci.sequence


def test_the_tutorials_order() -> None:
    assert run(10) == [0, 1, 1, 2, 3, 5, 8, 13, 21, 34, 55]


@pytest.mark.parametrize("order", [0, 1])
def test_the_first_two_are_there_from_the_start(order: int) -> None:
    assert run(order) == [0, 1]


def test_the_largest_order_just_fits_in_an_int32() -> None:
    largest, *_rest = sorted(run(MAX_ORDER), reverse=True)
    assert largest < 2**31 <= run(MAX_ORDER + 1)[-1]


@pytest.mark.parametrize("order", [-1, MAX_ORDER + 1, 2**31 - 1])
def test_other_orders_are_refused(order: int) -> None:
    assert str(order) in (check_order(order) or "")
    assert check_order(MAX_ORDER) is None
