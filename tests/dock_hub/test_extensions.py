"""The extensions of a hub, and what docs/write-an-extension.md says about them."""

import re
from pathlib import Path

from dock_hub.extensions import hub_extensions
from dock_hub.settings import EXTENSIONS

PAGE = Path(__file__).parents[2] / "docs/write-an-extension.md"


def test_the_page_names_them() -> None:
    sentence = re.search(r"^A hub has .+? of ours, (.+?), which need", PAGE.read_text(), re.MULTILINE)
    assert sentence is not None
    assert set(re.findall(r"`(\w+)`", sentence[1])) == EXTENSIONS
    assert set(hub_extensions().names) <= EXTENSIONS
