"""The settings of logins with an OpenID Connect provider."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_types import TUNING, Algorithms, Issuer, OptionalSecret, OptionalText, RoleNames


class SingleSignOnSettings(SettingsGroup):
    """The settings of logins with an OpenID Connect provider."""

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
