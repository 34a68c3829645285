"""The databases of the gateway's tests, for those of the hub."""

from tests.dock_gateway.conftest import (  # noqa: F401 - fixtures
    database_url,
    history_timeouts,
    postgresql_server,
    postgresql_url,
    quick_hashes,
    sqlite_url,
)
