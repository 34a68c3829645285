"""Reads the provider's claims about a person or a service: their name, and what they may do. Pure."""

import hashlib
from collections.abc import Mapping
from typing import Any

from dock_gateway.core.errors import NotAllowed, NotAuthenticated
from dock_gateway.core.grant import MAX_PATTERN, MAX_PATTERNS, Grant, Role
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from dock_gateway.setting_types import PATTERN

Claims = Mapping[str, Any]

# No user and no token has a name that begins with this.
PREFIX = "oidc:"
# Characters of a name in a record, and of the digest that ends a name which is too long.
MAX_NAME, DIGEST = 60, 16
# Characters of an id at the provider (OpenID Connect Core, 2).
MAX_SUBJECT = 255
# The one claim whose values are separated by spaces (RFC 8693, 4.2).
SCOPE = "scope"


class ClaimRules:
    """Makes a name and a grant of claims, as the settings say.

    Args:
        settings: The settings.
    """

    def __init__(self, settings: SingleSignOnSettings) -> None:
        pairs = (pair.rpartition("=") for pair in settings.oidc_roles)
        self._roles = {value.strip(): Role(role.strip()) for value, _, role in pairs}
        self._role_claim = settings.oidc_role_claim
        self._name_claim = settings.oidc_name_claim
        # In the order of `LIMITS`.
        self._limits = settings.oidc_robots_claim, settings.oidc_actions_claim, settings.oidc_topics_claim

    @property
    def needed(self) -> tuple[str, ...]:
        """The claims that decide what someone may do."""
        return (self._role_claim, *filter(None, self._limits))

    def name_of(self, claims: Claims) -> str:
        """Return the name under which someone is recorded: `oidc:` and their name at the provider.

        Raises:
            NotAuthenticated: It is none (`login_failed`).
        """
        found = find_claim(claims, self._name_claim)
        value = subject_of(claims) if found is None else found
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise NotAuthenticated(f"the claim {self._name_claim} is not a name", code="login_failed")
        name = PREFIX + value.strip()
        if len(name) > MAX_NAME:
            digest = hashlib.sha256(name.encode(errors="surrogatepass")).hexdigest()[:DIGEST]
            name = f"{name[: MAX_NAME - DIGEST - 1]}~{digest}"
        return name

    def grant_of(self, claims: Claims) -> Grant:
        """Return what someone may do.

        Raises:
            NotAllowed: They have no role, or a claim that limits it is missing or not valid (`role_required`).
        """
        values = _texts(claims, self._role_claim)
        roles = [self._roles[value] for value in values if value in self._roles]
        if not roles:
            detail = f"the claim {self._role_claim} has no value that oidc_roles gives a role"
            raise NotAllowed(detail, code="role_required")
        role = max(roles, key=list(Role).index)
        if role is Role.ADMIN:
            return Grant(role)
        return Grant(role, *(_patterns(claims, claim) if claim else () for claim in self._limits))


def subject_of(claims: Claims) -> str:
    """Return the provider's id of someone.

    Raises:
        NotAuthenticated: There is none (`login_failed`).
    """
    subject = claims.get("sub")
    if not isinstance(subject, str) or not 0 < len(subject) <= MAX_SUBJECT or not subject.isprintable():
        raise NotAuthenticated("the claim sub is missing or not valid", code="login_failed")
    return subject


def find_claim(claims: Claims, name: str) -> Any:
    """Return a claim; `a.b` is the claim with this name, or `b` in the claim `a`. None if there is none."""
    if name in claims:
        return claims[name]
    found: Any = claims
    for part in name.split("."):
        if not isinstance(found, Mapping):
            return None
        found = found.get(part)
    return found


def _texts(claims: Claims, name: str) -> list[str]:
    value = find_claim(claims, name)
    if isinstance(value, str):
        return value.split(" ") if name == SCOPE else [value]
    return [each for each in value if isinstance(each, str)] if isinstance(value, list) else []


def _patterns(claims: Claims, name: str) -> tuple[str, ...]:
    """Return the patterns of a claim: all of them have to be valid, as a limit must not become wider by a mistake."""
    value = find_claim(claims, name)
    patterns = [value] if isinstance(value, str) else value
    if (
        not isinstance(patterns, list)
        or not 0 < len(patterns) <= MAX_PATTERNS
        or not all(isinstance(each, str) and len(each) <= MAX_PATTERN and PATTERN.fullmatch(each) for each in patterns)
    ):
        raise NotAllowed(
            f"the claim {name} is missing, or is not a list of names such as /hall_a/*", code="role_required"
        )
    return tuple(dict.fromkeys(patterns))
