"""Who comes through the tunnel: signed by the hub, with at most what the site allows it."""

import time
from pathlib import Path

import orjson
import pytest

from dock_gateway.core.access import PrincipalKind
from dock_gateway.core.errors import NotAuthenticated
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.extensions.sites.admission import HubAdmission
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.sites.identity import IdentityReused, Signer

INSTANCE = "0123456789abcdef"
REQUEST = ("POST", "/dock")


@pytest.fixture
def signer(tmp_path: Path) -> Signer:
    return Signer.load_or_create(tmp_path / "hub.key")


def admission(signer: Signer, folder: Path, role: str = "operator", robots: str = "") -> HubAdmission:
    (keys := folder / "hub.json").write_bytes(orjson.dumps(signer.public_keys()))
    settings = SiteSettings(
        nats="nats://127.0.0.1", site="berlin", hub_public_keys=keys, hub_role=role, hub_robots=robots
    )  # type: ignore[arg-type]
    return HubAdmission(settings, INSTANCE, HubLink("berlin"))


def test_a_user_of_the_hub_has_at_most_what_the_site_allows(signer: Signer, tmp_path: Path) -> None:
    admit = admission(signer, tmp_path, robots="/hall_a/*")
    grant = Grant(Role.SUPERVISOR, ("*/robot1",))
    alice = admit(signer.sign("berlin", INSTANCE, "alice", grant, *REQUEST, time.time()), *REQUEST)
    assert (alice.name, alice.kind, alice.grant.role) == ("hub:alice", PrincipalKind.FORWARDED, Role.OPERATOR)
    covered = [robot for robot in ("/robot1", "/hall_a/robot1", "/hall_a/robot2") if alice.grant.covers_robot(robot)]
    assert covered == ["/hall_a/robot1"]


def test_a_hub_that_was_taken_over(signer: Signer, tmp_path: Path) -> None:
    admit = admission(signer, tmp_path, "viewer", "/robot1")
    root = admit(signer.sign("berlin", INSTANCE, "root", UNLIMITED, *REQUEST, time.time()), *REQUEST)
    assert root.grant == Grant(Role.VIEWER, ("/robot1",))


def test_a_hub_that_asks_nobody(signer: Signer, tmp_path: Path) -> None:
    admit = admission(signer, tmp_path, "admin")
    token = signer.sign("berlin", INSTANCE, None, UNLIMITED, *REQUEST, time.time())
    anybody = admit(token, *REQUEST)
    assert (anybody.name, anybody.grant) == ("hub", UNLIMITED)
    with pytest.raises(IdentityReused):
        admit(token, *REQUEST)
    with pytest.raises(NotAuthenticated, match="it has expired"):
        admit(signer.sign("berlin", INSTANCE, None, UNLIMITED, *REQUEST, time.time() - 3600), *REQUEST)
