"""The settings of a hub: a wrong one is refused with its name."""

import click
import pytest

from dock_gateway.cli.options import read_settings_of
from dock_gateway.settings import Settings, unknown_variables
from dock_hub.settings import HubSettings


def test_they_are_read_and_known() -> None:
    settings = read_settings_of(HubSettings, {"nats": "nats://nats:4222", "allow_plain_nats": "true"})
    assert settings.nats == ("nats://nats:4222",)
    assert settings.hub_key_file.name == "hub.key"
    assert unknown_variables(["DOCK_GATEWAY_NATS"], HubSettings.model_fields) == []
    assert unknown_variables(["DOCK_GATEWAY_NATS"], Settings.model_fields) != []


def test_a_server_on_another_machine_needs_tls() -> None:
    with pytest.raises(click.UsageError, match="nats names a NATS server on another machine without TLS"):
        read_settings_of(HubSettings, {"nats": "nats://nats.example.com"})
