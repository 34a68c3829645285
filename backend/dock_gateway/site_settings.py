"""The settings of a site that has a hub: docs/extensions/sites.md."""

from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic_settings import BaseSettings

from dock_gateway.setting_types import Brokers, OptionalFile, RobotPatterns, SiteName, is_safe_broker


class SiteSettings(BaseSettings):
    """The part of `Settings` that is about a hub."""

    hub: Brokers = Field(
        (),
        description="NATS servers, separated by commas, over which a hub reaches this gateway: "
        "`tls://nats.example.com:4222` ([sites.md](extensions/sites.md)). Empty: no hub.",
    )
    site: SiteName = Field("", description="Name of this site at its hub, such as `berlin`.")
    hub_key: OptionalFile = Field(
        None,
        description="File with the hub's public keys, as `dock-gateway hub-key` prints them there. Only what they have "
        "signed is believed.",
    )
    hub_role: Literal["viewer", "agent", "operator", "supervisor", "admin"] = Field(
        "operator", description="The highest role that anyone has here through the hub."
    )
    hub_robots: RobotPatterns = Field(
        (),
        description="Robots that the hub may see and move, separated by commas: `/robot1`, or `/hall_a/*`, where `*` "
        "stands for any text. Empty: every robot.",
    )
    nats_credentials: OptionalFile = Field(
        None, description="File with the credentials (`.creds`) of this site or hub at the NATS servers."
    )
    nats_ca: OptionalFile = Field(
        None,
        description="PEM file with the certificate authorities of the NATS servers. Empty: those of this machine.",
    )
    nats_insecure: bool = Field(
        False,
        description="Whether NATS servers on other machines may be used without TLS, `nats://` instead of `tls://`: "
        "then others on the network may read and change what is sent.",
    )

    @model_validator(mode="after")
    def _check_site(self) -> Self:
        if not self.hub:
            needless = (name for name in ("site", "hub_key", "hub_robots") if getattr(self, name))
            if (name := next(needless, None)) is not None:
                raise ValueError(f"{name} needs hub, the NATS servers over which the hub reaches this site")
        elif not self.site:
            raise ValueError("hub needs site, the name of this site, such as berlin")
        elif self.hub_key is None:
            raise ValueError("hub needs hub_key: a file with what `dock-gateway hub-key` prints at the hub")
        elif self.hub_role == "admin" and self.hub_robots:
            raise ValueError("hub_robots limits no admin, who can change any limit: choose a lower hub_role")
        return self

    @property
    def brokers(self) -> dict[str, Brokers]:
        """The NATS servers, by the name of the setting."""
        return {"hub": self.hub}

    @model_validator(mode="after")
    def _check_brokers(self) -> Self:
        for name, servers in self.brokers.items():
            if not self.nats_insecure and not all(map(is_safe_broker, servers)):
                raise ValueError(
                    f"{name} names a NATS server on another machine without TLS: write tls:// instead of nats://, or "
                    "allow it with nats_insecure"
                )
        return self
