"""The permit of a request, for tests of what is below the doors."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any

from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.grant import Grant, Role
from dock_gateway.core.request import PERMIT, Permit
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings


def user(name: str | None, role: Role = Role.ADMIN, address: str = "") -> Principal:
    """Someone with this name; without a name, a client at an address where no one logs in."""
    kind = PrincipalKind.ANYBODY if name is None else PrincipalKind.TOKEN
    return Principal(name, kind, Grant(role), name, address=address)


def permit(
    quotas: Quotas | None = None,
    principal: Principal | None = None,
    *,
    require: Callable[[], None] = lambda: None,
    watch: Any = lambda _: nullcontext(),
) -> Permit:
    """A permit with the quotas of a user."""
    quotas, principal = quotas or Quotas(Settings()), principal or user("ada")
    return Permit(require, watch, partial(quotas.slot, principal), partial(quotas.turn, principal))


@contextmanager
def acting(quotas: Quotas, principal: Principal) -> Iterator[None]:
    """Do what the block does for a user."""
    token = PERMIT.set(permit(quotas, principal))
    try:
        yield
    finally:
        PERMIT.reset(token)
