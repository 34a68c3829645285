"""Fixtures for every test that needs ROS."""

import os
import signal
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest
from hypothesis import Phase, settings

from tests.support import shapes
from tests.support.domain import ros_domain
from tests.support.observer import Observer, ros_observer

# Nodes in the test process, too, stay on this machine.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

# Tests that have a time limit of their own say so: a busy machine takes its time.
settings.register_profile("busy machine", deadline=None)
# For `make mutation`: the same examples for every mutant, and no search for the smallest one that kills it.
phases = [Phase.explicit, Phase.generate]
settings.register_profile("mutation", deadline=None, derandomize=True, database=None, phases=phases)
settings.load_profile("busy machine")

# The folders of tests that take long.
LONG = ("chaos", "browser", "system")

numbers = count()


def pytest_configure(config: pytest.Config) -> None:
    """Prepare the process: see the comments."""
    # A suite that runs under `nohup` must not hand that on to the programs that it ends by a signal.
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    # Kilted's rclpy calls its own `warn`.
    config.addinivalue_line("filterwarnings", "ignore:Deprecated in favor of .*RcutilsLogger:DeprecationWarning")
    # The one warning that importing ROS messages brings: its parser is older than Python's new `re`.
    config.addinivalue_line("filterwarnings", "ignore:module 'sre_.*' is deprecated:DeprecationWarning")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Browsers and floods need the processor, robots need time: the files of each kind are spread evenly over the run.

    Unit tests, which are short, are what is left for the end.
    """
    kinds: dict[str, list[Path]] = {}
    files: dict[Path, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)
    for path in files:
        kinds.setdefault(path.parent.name if path.parent.name in LONG else "unit", []).append(path)
    places: dict[Path, float] = {}
    for kind, paths in kinds.items():
        places |= {path: index / len(paths) * (0.9 if kind in LONG else 1.0) for index, path in enumerate(paths)}
    items[:] = [item for path in sorted(files, key=lambda path: places[path]) for item in files[path]]


@pytest.fixture(autouse=True)
def own_data_directory(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a gateway keeps in the user's directories is the test's own, in a folder that it makes itself."""
    folder = str(tmp_path_factory.getbasetemp() / f"data{next(numbers)}")
    monkeypatch.setenv("XDG_DATA_HOME", folder)
    monkeypatch.setenv("XDG_STATE_HOME", folder)


@pytest.fixture(autouse=True)
def documented() -> Iterator[None]:
    """A test fails if a gateway sent it anything that the OpenAPI document does not describe."""
    yield
    assert not (differences := shapes.noted()), "not as in the OpenAPI document:\n" + "\n".join(differences)


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS domain that this test has for itself."""
    with ros_domain() as number:
        yield number


@pytest.fixture
def observer(domain: int) -> Iterator[Observer]:
    """A node on that domain: listens, publishes, sends goals."""
    with ros_observer(domain) as node:
        yield node
