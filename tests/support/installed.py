"""What of the core's tests needs an extension: it is left out in a working copy that the extension was taken out of."""

from collections.abc import Mapping

import pytest

from dock_gateway.extension_list import OURS


def is_there(name: str, extensions: Mapping[str, str]) -> bool:
    """Return whether a case can be tested: the extension that it is about, if any, is there."""
    return extensions.get(name) in {None, *OURS}


def needs(*names: str) -> pytest.MarkDecorator:
    """Skip a test, or with `pytestmark` a module, where one of these extensions is not there."""
    missing = [name for name in names if name not in OURS]
    return pytest.mark.skipif(bool(missing), reason=f"without {', '.join(missing)}")
