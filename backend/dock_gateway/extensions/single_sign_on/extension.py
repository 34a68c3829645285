"""Logins at an OpenID Connect provider, where the settings have one: docs/extensions/single_sign_on.md."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

from dock_gateway.access.logins import Logins
from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.single_sign_on.error_codes import CODES
from dock_gateway.extensions.single_sign_on.logins import ProviderLogins
from dock_gateway.extensions.single_sign_on.routes import router
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings
from dock_gateway.extensions.single_sign_on.single_sign_on import SingleSignOn
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Limit
from dock_gateway.settings import Settings
from dock_gateway.storage import History


@asynccontextmanager
async def open_single_sign_on(parts: Parts) -> AsyncIterator[ProviderLogins]:
    """Let people and services of the provider log in, if there is one."""
    settings, logins = parts[Settings], parts[Logins]
    provider = settings.of(SingleSignOnSettings)
    sso = None if provider.oidc_issuer is None else SingleSignOn(provider)
    async with closing(ProviderLogins(parts[History], logins.guard, sso)) as found:
        if settings.authentication:
            await found.open()
        with logins.sources.adding(found):
            yield found


def login_limits(_: Settings) -> Mapping[str, Limit]:
    """Return what users share of it: logins that are in progress."""
    return {"provider logins": Limit("logins in progress", 20, 5, code="too_many_logins", of_address=5)}


extension = Extension(
    "single_sign_on",
    open_single_sign_on,
    settings=SingleSignOnSettings,
    routes=lambda _: (router,),
    errors=CODES,
    limits=login_limits,
)
