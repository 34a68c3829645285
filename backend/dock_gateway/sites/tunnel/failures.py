"""The failures that keep the hub from getting an answer of a site."""

from http import HTTPStatus

from dock_gateway.core.errors import GatewayError, ServerTimeout, Unavailable
from dock_gateway.sites.messages import Refusal
from dock_gateway.sites.tunnel.channel import ChannelEnded


class SiteUnreachable(Unavailable):
    """There is no connection to a site. It has not got the request."""

    code = "site_unreachable"

    def __init__(self, site: str, detail: str) -> None:
        super().__init__(f"the site {site} is not connected: {detail}", site=site)


class SiteTimeout(ServerTimeout):
    """A site has not answered. Whether it has acted is not known."""

    code = "site_timeout"

    def __init__(self, site: str, detail: str) -> None:
        super().__init__(f"the site {site} {detail}; whether it has acted is not known", site=site)


class SiteFailed(GatewayError):
    """A site has refused or given up a request for a reason that is not its sender's."""

    status = HTTPStatus.BAD_GATEWAY
    code = "site_failed"


def silent_for(site: str, seconds: float) -> SiteTimeout:
    """Return the error that a site did not answer in time."""
    return SiteTimeout(site, f"did not answer within {seconds:g} s")


def ended_early(site: str, ended: ChannelEnded) -> GatewayError:
    """Return the error that a stream ended before its answer."""
    if ended.reason in {"broker_unavailable", "silent"}:
        return SiteTimeout(site, f"was lost before it answered: {ended.detail}")
    return SiteFailed(
        f"the site {site} did not answer: {ended.detail}; whether it has acted is not known",
        reason=ended.reason,
        site=site,
    )


def refused(site: str, refusal: Refusal) -> GatewayError:
    """Return the error for a refusal of a site. A site that does not believe the hub is not the client's fault."""
    if refusal.status == HTTPStatus.UNAUTHORIZED:
        detail = f"the site {site} does not accept this hub: {refusal.detail}"
        return SiteFailed(detail, code="site_refused", reason=refusal.code, site=site)
    try:
        status = HTTPStatus(refusal.status)
    except ValueError:
        status = HTTPStatus.BAD_GATEWAY
    return GatewayError(refusal.detail, code=refusal.code, status=status, site=site)
