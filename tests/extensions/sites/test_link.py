"""What a site says of its hub."""

from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.observability.schema import HubState


def test_a_hub_with_another_key_is_named_until_it_is_believed() -> None:
    link = HubLink("berlin")
    link.doubt("invalid_identity", "another key")
    assert link.code is None  # before it is connected, others may say what they like
    link.connected("0.1.0")
    link.doubt("invalid_identity", "another key")
    link.connected("0.1.0")  # the next hello
    assert (link.state, link.code, link.detail) == (HubState.CONNECTED, "invalid_identity", "another key")
    link.believe()
    assert (link.code, link.detail) == (None, None)
    link.doubt("invalid_identity", "a stranger's")
    assert link.code is None
