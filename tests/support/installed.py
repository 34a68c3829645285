"""Tests of the core that use an extension: they are skipped in a working copy that it was taken out of."""

import pytest

from dock_gateway.extension_list import OURS


def needs(*names: str) -> pytest.MarkDecorator:
    """Skip a test, or with `pytestmark` a module, where one of these extensions is not there."""
    missing = [name for name in names if name not in OURS]
    return pytest.mark.skipif(bool(missing), reason=f"without {', '.join(missing)}")
