"""The page of sites lists the settings that only a hub has."""

from pathlib import Path

from dock_gateway.cli.options import TYPE, option_name
from dock_hub.settings import HubSettings

PAGE = Path(__file__).parents[3] / "docs/extensions/sites.md"


def test_every_setting_is_documented_as_it_is() -> None:
    rows = [line for line in PAGE.read_text().splitlines() if line.startswith("| `DOCK_GATEWAY_")]
    assert rows == [
        f"| `DOCK_GATEWAY_{name.upper()}` | `{option_name(name)}` | empty | {field.description} |"
        for name, field in HubSettings.model_fields.items()
        if name not in TYPE.model_fields
    ]
