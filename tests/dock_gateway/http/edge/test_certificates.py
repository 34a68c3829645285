"""The certificate: what cannot be used is named, and what has changed is used."""

import asyncio
import ssl
from pathlib import Path

import pytest
from cryptography.hazmat.primitives import serialization

from dock_gateway.http.edge.certificates import CertificateError, Certificates, load_certificates
from dock_gateway.settings import Settings
from tests.support.certificates import Authority, Pair
from tests.support.waiting import until


@pytest.fixture
def authority(tmp_path: Path) -> Authority:
    return Authority(tmp_path)


@pytest.fixture
def pair(authority: Authority) -> Pair:
    return authority.issue()


def encrypt(key: Path) -> None:
    private = serialization.load_pem_private_key(key.read_bytes(), None)
    encryption = serialization.BestAvailableEncryption(b"secret")
    key.write_bytes(private.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, encryption))


def test_without_settings_there_is_none() -> None:
    assert load_certificates(Settings()) is None


def test_a_context(pair: Pair, authority: Authority) -> None:
    context = Certificates(pair.cert, pair.key).context
    assert context.minimum_version is ssl.TLSVersion.TLSv1_2
    assert context.verify_mode is ssl.CERT_NONE
    assert Certificates(pair.cert, pair.key, authority.file).context.verify_mode is ssl.CERT_REQUIRED


@pytest.mark.parametrize("missing", ["cert", "key", "ca"])
def test_a_file_that_is_not_there(pair: Pair, authority: Authority, missing: str) -> None:
    path = {"cert": pair.cert, "key": pair.key, "ca": authority.file}[missing]
    ca = authority.file
    path.unlink()
    with pytest.raises(CertificateError, match=f"{path} cannot be read: No such file"):
        Certificates(pair.cert, pair.key, ca)


@pytest.mark.parametrize("wrong", ["cert", "key"])
def test_a_file_that_holds_something_else(pair: Pair, wrong: str) -> None:
    getattr(pair, wrong).write_text("something else")
    with pytest.raises(CertificateError) as error:
        Certificates(pair.cert, pair.key)
    assert str(pair.cert) in str(error.value)
    assert str(pair.key) in str(error.value)


def test_authorities_that_are_none(pair: Pair, tmp_path: Path) -> None:
    (ca := tmp_path / "wrong.pem").write_text("something else")
    with pytest.raises(CertificateError, match=f"{ca} holds no PEM certificate"):
        Certificates(pair.cert, pair.key, ca)


def test_a_key_of_another_certificate(pair: Pair, authority: Authority) -> None:
    other = authority.issue("other")
    with pytest.raises(CertificateError, match=f"the key in {other.key} is not that of the certificate in {pair.cert}"):
        Certificates(pair.cert, other.key)


def test_a_key_with_a_passphrase_is_refused_and_nobody_is_asked_for_it(pair: Pair) -> None:
    encrypt(pair.key)
    with pytest.raises(CertificateError, match=f"{pair.key} no PEM key without a passphrase"):
        Certificates(pair.cert, pair.key)


def test_a_new_pair_is_used(pair: Pair, authority: Authority) -> None:
    certificates = Certificates(pair.cert, pair.key)
    before = certificates.context
    certificates.refresh()
    assert certificates.context is before
    authority.issue("new", into=pair)
    certificates.refresh()
    assert certificates.context is not before


def test_a_broken_new_pair_is_logged_once_and_the_old_one_remains(
    pair: Pair, authority: Authority, caplog: pytest.LogCaptureFixture
) -> None:
    certificates = Certificates(pair.cert, pair.key)
    before = certificates.context
    good = pair.key.read_bytes()
    for broken in (b"broken", b""):
        pair.key.write_bytes(broken)
        certificates.refresh()
        certificates.refresh()
        assert certificates.context is before
    assert caplog.text.count("the old one remains in use") == 2
    pair.key.unlink()
    certificates.refresh()
    assert certificates.context is before
    assert "cannot be read" in caplog.text
    pair.key.write_bytes(good)
    certificates.refresh()
    assert certificates.context is not before


async def test_files_are_watched(pair: Pair, authority: Authority) -> None:
    certificates = Certificates(pair.cert, pair.key, interval=0.01)
    before = certificates.context
    watching = asyncio.create_task(certificates.watch())
    authority.issue("new", into=pair)
    await until(lambda: certificates.context is not before)
    watching.cancel()
