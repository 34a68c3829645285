"""How a leak is told from memory that an allocator keeps."""

from collections.abc import Iterator

import pytest

from tests.chaos.withstand import REPEATS, leave_nothing


class Machine:
    """The memory in use, in MB, after each of some floods."""

    def __init__(self, levels: Iterator[float]) -> None:
        self.levels = levels
        self.used = 200.0
        self.floods = 0

    def flood(self) -> None:
        self.used = next(self.levels)
        self.floods += 1

    def look(self) -> None:
        leave_nothing(self.flood, lambda: self.used, 20, patience=0.0)


@pytest.mark.parametrize("levels", [[219.0], [224.0, 224.5], [224.0, 234.0, 236.0], [224.0, 210.0]])
def test_memory_that_comes_back_or_is_used_again(levels: list[float]) -> None:
    machine = Machine(iter(levels))
    machine.look()
    assert machine.floods == len(levels)


@pytest.mark.parametrize("leak", [21.0, 50.0, 500.0])
def test_a_leak_takes_as_much_each_time(leak: float) -> None:
    machine = Machine(200.0 + leak * flood for flood in range(1, 100))
    with pytest.raises(AssertionError, match="each flood takes more memory"):
        machine.look()
    assert machine.floods == 1 + REPEATS
