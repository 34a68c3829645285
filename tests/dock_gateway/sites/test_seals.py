"""A site knows the messages of its hub by a seal, and no others."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.sites.seals import KeyAgreement, seal, unseal, without_seal

HUB, SITE, STRANGER = KeyAgreement(), KeyAgreement(), KeyAgreement()
KEY = HUB.agree(SITE.public, "berlin", "0" * 16)


def test_both_ends_have_the_same_key_and_no_one_else() -> None:
    assert SITE.agree(HUB.public, "berlin", "0" * 16) == KEY
    others = [
        STRANGER.agree(SITE.public, "berlin", "0" * 16),
        STRANGER.agree(HUB.public, "berlin", "0" * 16),
        SITE.agree(HUB.public, "oslo", "0" * 16),
        SITE.agree(HUB.public, "berlin", "1" * 16),
    ]
    assert len({KEY, *others}) == 5


@pytest.mark.parametrize("public", ["", "x", "AAAA", "A" * 43, "ä", "\0", "A" * 60])
def test_what_is_no_public_key(public: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - the text is that of a library
        HUB.agree(public, "berlin", "0" * 16)


@given(st.binary())
def test_a_sealed_message_is_the_message(message: bytes) -> None:
    assert unseal(KEY, seal(KEY, message)) == message
    assert unseal(None, seal(KEY, message)) is None
    opened = without_seal(seal(KEY, b"{" + message))  # as before the ends have agreed
    assert opened == without_seal(opened) == b"{" + message
    assert unseal(KEY, seal(STRANGER.agree(SITE.public, "berlin", "0" * 16), message)) is None


@given(st.binary(), st.data())
def test_no_byte_of_it_can_be_changed(message: bytes, data: st.DataObject) -> None:
    sealed = bytearray(seal(KEY, message))
    place = data.draw(st.integers(0, len(sealed) - 1))
    sealed[place] ^= data.draw(st.integers(1, 255))
    assert unseal(KEY, bytes(sealed)) is None
    assert unseal(KEY, bytes(sealed[: data.draw(st.integers(0, len(sealed)))])) is None


@given(st.binary())
def test_other_bytes_have_no_seal(data: bytes) -> None:
    assert unseal(KEY, data) is None
