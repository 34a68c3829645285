"""The browser of other tests."""

from tests.browser.conftest import (  # noqa: F401 - fixtures and hooks
    browser,
    domain,
    gateway,
    page,
    pytest_collection_modifyitems,
    pytest_runtest_makereport,
)
