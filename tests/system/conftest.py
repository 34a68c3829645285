"""What the tests of a module share, where starting it for each of them would take too long."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.access import Site, bearer
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway


@pytest.fixture(scope="module")
def shared_domain() -> Iterator[int]:
    """A ROS domain that the tests of a module have for themselves."""
    with ros_domain() as number:
        yield number


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    """A gateway on that domain."""
    with running_gateway(shared_domain) as gateway:
        yield gateway


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    """A database with users and tokens that the tests of a module share."""
    return Site(Path(tmp_path_factory.mktemp("site")))


@pytest.fixture(scope="module")
def root(site: Site) -> dict[str, str]:
    """A user of the robot without a namespace."""
    return bearer(site.token("root", "operator", "--robot", "/"))
