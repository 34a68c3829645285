"""The layout for viewers."""

import json
from pathlib import Path
from typing import Any

LAYOUT = json.loads((Path(__file__).parents[3] / "observability/foxglove-layout.json").read_text())


def panels(place: Any) -> list[str]:
    return [place] if isinstance(place, str) else panels(place["first"]) + panels(place["second"])


def test_each_panel_has_its_place_and_its_settings() -> None:
    assert sorted(panels(LAYOUT["layout"])) == sorted(LAYOUT["configById"])
