"""The settings of a site that has a hub."""

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from dock_gateway.setting_types import Brokers, OptionalFile, RobotPatterns, SiteName
from dock_gateway.settings import ExtensionSettings
from dock_gateway.sites.settings import BrokerSettings, find_broker_fault


class SiteSettings(BrokerSettings, ExtensionSettings):
    """The settings of a site: how its hub reaches this gateway, and what the hub may do."""

    group: ClassVar[str] = "Sites"

    nats: Brokers = Field(
        (),
        description="NATS servers, separated by commas, over which a hub reaches this gateway: "
        "`tls://nats.example.com:4222` ([sites.md](extensions/sites.md)). Empty: no hub.",
    )
    site: SiteName = Field("", description="Name of this site at its hub, such as `berlin`.")
    hub_public_keys: OptionalFile = Field(
        None,
        description="File with the hub's public keys, as `dock-gateway hub key` prints them there. Only what they have "
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

    @model_validator(mode="after")
    def _check_site(self) -> Self:
        if not self.nats:
            needless = (name for name in ("site", "hub_public_keys", "hub_robots") if getattr(self, name))
            if (name := next(needless, None)) is not None:
                raise ValueError(f"{name} needs nats, the NATS servers over which the hub reaches this site")
        elif not self.site:
            raise ValueError("nats needs site, the name of this site, such as berlin")
        elif self.hub_public_keys is None:
            raise ValueError("nats needs hub_public_keys: a file with what `dock-gateway hub key` prints at the hub")
        elif self.hub_role == "admin" and self.hub_robots:
            raise ValueError("hub_robots limits no admin, who can change any limit: choose a lower hub_role")
        return self

    @property
    def brokers(self) -> dict[str, Brokers]:
        """The NATS servers, by the name of the setting."""
        return {"nats": self.nats}

    def find_fault(self) -> str | None:
        """Return a sentence about files with which a hub cannot reach this site, or what it signs not be verified."""
        if not self.nats and (self.nats_credentials or self.nats_ca):
            return "nats_credentials and nats_ca need nats"
        if not self.nats or self.hub_public_keys is None:
            return None
        from dock_gateway.sites.identity import KeyFault, Verifier  # noqa: PLC0415 - only sites with a hub need it

        try:
            Verifier(self.hub_public_keys, self.site)
        except KeyFault as error:
            return str(error)
        return find_broker_fault(self)
