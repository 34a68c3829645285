"""The settings of a connection to NATS servers, which a site and a hub have alike."""

import ssl
from typing import ClassVar, Self

from pydantic import Field, model_validator

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_types import Brokers, OptionalFile, is_safe_broker
from dock_gateway.sites.credentials import read_credentials


class BrokerSettings(SettingsGroup):
    """The settings of connections to NATS servers."""

    group: ClassVar[str] = "Sites"

    nats_credentials: OptionalFile = Field(
        None, description="File with the credentials (`.creds`) of this site or hub at the NATS servers."
    )
    nats_ca: OptionalFile = Field(
        None,
        description="PEM file with the certificate authorities of the NATS servers. Empty: those of this machine.",
    )
    allow_plain_nats: bool = Field(
        False,
        description="Whether NATS servers on other machines may be used without TLS, `nats://` instead of `tls://`: "
        "then others on the network may read and change what is sent.",
    )

    @property
    def brokers(self) -> dict[str, Brokers]:
        """The NATS servers, by the name of the setting."""
        return {}

    @model_validator(mode="after")
    def _check_brokers(self) -> Self:
        for name, servers in self.brokers.items():
            if not self.allow_plain_nats and not all(map(is_safe_broker, servers)):
                raise ValueError(
                    f"{name} names a NATS server on another machine without TLS: write tls:// instead of nats://, or "
                    "allow it with allow_plain_nats"
                )
        return self


def find_broker_fault(settings: BrokerSettings) -> str | None:
    """Return why no NATS server can be reached with these files; None if one can. None is looked for."""
    try:
        if settings.nats_credentials is not None:
            read_credentials(settings.nats_credentials)
    except ValueError as error:
        return f"nats_credentials: {error}"
    try:
        if settings.nats_ca is not None:
            ssl.create_default_context(cafile=settings.nats_ca)
    except OSError as error:  # SSLError is one
        return f"nats_ca: {settings.nats_ca} is no PEM file with certificates: {error}"
    return None
