"""The settings of an identity provider: OpenID Connect."""

import re
from typing import Annotated, ClassVar, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, model_validator

from dock_gateway.core.grant import Role
from dock_gateway.setting_types import LOOPBACK_HOSTS, TUNING, OptionalSecret, OptionalText, Texts
from dock_gateway.settings import ExtensionSettings

# Signatures that a provider publishes keys for: neither `none` nor those with a shared secret are among them.
SIGNATURES = frozenset(
    {"RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "ES512", "EdDSA", "Ed25519"}
)
ROLES = frozenset(Role)


def is_safe_address(value: str) -> bool:
    """Return whether a text is an address that can be asked safely: over TLS, or on this machine."""
    try:
        address = urlsplit(value)
        host = address.hostname
        _ = address.port
    except ValueError:
        return False
    safe = address.scheme == "https" or (address.scheme == "http" and host in LOOPBACK_HOSTS)
    return bool(safe and host and value.isprintable() and not re.search(r"[ #@\\]", value))


def _check_algorithms(parts: tuple[str, ...]) -> tuple[str, ...]:
    if not parts or not SIGNATURES.issuperset(parts):
        raise ValueError(f"choose from {', '.join(sorted(SIGNATURES))}, separated by commas")
    return parts


def _check_roles(parts: tuple[str, ...]) -> tuple[str, ...]:
    for part in parts:
        claimed, _, role = part.rpartition("=")
        if not claimed.strip() or role.strip() not in ROLES:
            raise ValueError(
                f"{part[:100]!r} is not like robot-ops=operator; roles are viewer, agent, operator, supervisor and "
                "admin"
            )
    return parts


def _check_issuer(value: str | None) -> str | None:
    if value is not None and not (is_safe_address(value) and "?" not in value):
        raise ValueError(
            f"{value[:100]!r} is not an address such as https://login.example.com/realms/site; only a provider on this "
            "machine may be at http"
        )
    return value


Issuer = Annotated[OptionalText, AfterValidator(_check_issuer)]
Algorithms = Annotated[Texts, AfterValidator(_check_algorithms)]
RoleNames = Annotated[Texts, AfterValidator(_check_roles)]


class SingleSignOnSettings(ExtensionSettings):
    """The provider, and what its claims mean."""

    group: ClassVar[str] = "Single sign-on"

    oidc_issuer: Issuer = Field(
        None,
        description="Issuer of the OpenID Connect provider where people log in, such as "
        "`https://login.example.com/realms/site`: [single_sign_on.md](extensions/single_sign_on.md).",
    )
    oidc_client_id: OptionalText = Field(
        None,
        description="The gateway's client id at the provider, for people who use the dashboard. Empty: only services.",
    )
    oidc_client_secret: OptionalSecret = Field(
        None,
        description="The secret of that client; empty for a public client. Options can be seen by others.",
    )
    oidc_audience: OptionalText = Field(
        None,
        description="The audience (`aud`) of JWT access tokens for this gateway, such as `https://robots.example.com`. "
        "Empty: none are accepted.",
    )
    oidc_name: str = Field(
        "", max_length=40, description="What the login page calls the provider. Empty: the host name of the issuer."
    )
    oidc_scopes: str = Field(
        "openid profile",
        pattern="^[!#-\\[\\]-~]+( [!#-\\[\\]-~]+)*$",
        description="What the dashboard asks the provider for, separated by spaces; `openid` is needed.",
    )
    oidc_algorithms: Annotated[Algorithms, TUNING] = Field(
        ("RS256", "PS256", "ES256", "EdDSA", "Ed25519"),
        description="Algorithms of signatures that are accepted from the provider, separated by commas.",
    )
    oidc_name_claim: str = Field(
        "preferred_username",
        min_length=1,
        description="The claim with the name of a person or a service; `sub` is used where it is missing. It has to be "
        "one that people cannot change themselves.",
    )
    oidc_role_claim: str = Field(
        "roles",
        min_length=1,
        description="The claim with roles or groups: a text or a list. `realm_access.roles` is a claim in a claim.",
    )
    oidc_roles: RoleNames = Field(
        (),
        description="The role of each value of that claim: `robot-ops=operator,robot-admins=admin`. The highest "
        "counts; who has none of the values has no access.",
    )
    oidc_robots_claim: OptionalText = Field(
        None,
        description="The claim with the robots of a person or a service: a list of namespaces such as `/hall_a/*`. "
        "Without a valid one there is no access, but for admins. Empty: every robot.",
    )
    oidc_actions_claim: OptionalText = Field(None, description="The claim with the actions, likewise.")
    oidc_topics_claim: OptionalText = Field(None, description="The claim with the topics, likewise.")
    oidc_session_hours: float = Field(
        12.0, gt=0, le=720, description="Hours after which a login with the provider ends at the latest."
    )

    @model_validator(mode="after")
    def _check_oidc(self) -> Self:
        if self.oidc_issuer is None:
            if needless := sorted(
                name for name in self.model_fields_set if name.startswith("oidc_") and getattr(self, name)
            ):
                raise ValueError(f"{needless[0]} needs oidc_issuer")
            return self
        if not getattr(self, "authentication", True):
            raise ValueError("oidc_issuer needs authentication: without it no one logs in")
        if self.oidc_client_id is None and self.oidc_audience is None:
            raise ValueError("oidc_issuer needs oidc_client_id for people, or oidc_audience for services, or both")
        if self.oidc_client_id is None and self.oidc_client_secret is not None:
            raise ValueError("oidc_client_secret needs oidc_client_id")
        if self.oidc_client_id == self.oidc_audience:
            raise ValueError(
                "oidc_audience must not be oidc_client_id: the ID tokens of people would be accepted as access tokens"
            )
        if "openid" not in self.oidc_scopes.split():
            raise ValueError("oidc_scopes needs openid")
        if not self.oidc_roles:
            raise ValueError("oidc_issuer needs oidc_roles, such as robot-ops=operator: without it no one has a role")
        return self
