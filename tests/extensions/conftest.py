"""The databases and the gateway of other tests, for those of extensions."""

from tests.dock_gateway.conftest import (  # noqa: F401 - fixtures
    database_url,
    history_timeouts,
    place,
    postgresql_server,
    postgresql_url,
    quick_hashes,
    sqlite_url,
    stopped_clock,
)
from tests.dock_gateway.ros.conftest import bridge  # noqa: F401 - a fixture
from tests.system.conftest import gateway, root, shared_domain, site  # noqa: F401 - fixtures
