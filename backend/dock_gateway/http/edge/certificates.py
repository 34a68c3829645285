"""The gateway's certificate, loaded again when its files change."""

import asyncio
import logging
import ssl
from pathlib import Path

from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# Modification time, size and inode of each file.
Version = tuple[tuple[int, int, int], ...]


class CertificateError(Exception):
    """A file cannot be used. The message names it."""


class Certificates:
    """Holds the SSL context for new connections.

    Args:
        cert: PEM file with the certificate and its intermediates.
        key: PEM file with its private key.
        client_ca: PEM file with the authorities of client certificates; None: clients need none.
        interval: Seconds between two checks of the files.

    Raises:
        CertificateError: A file cannot be used.
    """

    def __init__(self, cert: Path, key: Path, client_ca: Path | None = None, *, interval: float = 2.0) -> None:
        self._interval = interval
        self._cert = cert
        self._key = key
        self._client_ca = client_ca
        self._version = self._read_version()
        self.context = self._load()

    async def watch(self) -> None:
        """Load the files again whenever they change, until cancelled."""
        while True:
            await asyncio.sleep(self._interval)
            await asyncio.to_thread(self.refresh)

    def refresh(self) -> None:
        """Load the files if they have changed. If they cannot be used, the old certificate remains in use."""
        version = self._read_version()
        if version == self._version:
            return
        self._version = version
        try:
            self.context = self._load()
        except CertificateError as error:
            log.error("the certificate has changed, and the old one remains in use: %s", error)
        else:
            log.info("the certificate has changed: %s", self._cert)

    def _read_version(self) -> Version:
        found = []
        for path in self._paths:
            try:
                state = path.stat()
            except OSError:
                found.append((0, 0, 0))
            else:
                found.append((state.st_mtime_ns, state.st_size, state.st_ino))
        return tuple(found)

    @property
    def _paths(self) -> tuple[Path, ...]:
        return (self._cert, self._key, *([] if self._client_ca is None else [self._client_ca]))

    def _load(self) -> ssl.SSLContext:
        """Return a new context: a failure to load another certificate would leave an old one without its key."""
        for path in self._paths:
            try:
                path.read_bytes()
            except OSError as error:
                raise CertificateError(f"{path} cannot be read: {error.strerror}") from None
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        # A ticket arrives after the handshake. A client that reads in one thread while it writes its first request in
        # another, as `websockets.sync` does, can lose that request then (seen with CPython 3.11).
        context.num_tickets = 0
        try:
            context.load_cert_chain(self._cert, self._key, password="")  # an empty one, as none would be asked for
        except ssl.SSLError as error:
            if error.reason == "KEY_VALUES_MISMATCH":
                raise CertificateError(
                    f"the key in {self._key} is not that of the certificate in {self._cert}"
                ) from None
            raise CertificateError(
                f"{self._cert} holds no PEM certificate, or {self._key} no PEM key without a passphrase "
                f"({error.reason or error})"
            ) from None
        if self._client_ca is not None:
            context.verify_mode = ssl.CERT_REQUIRED
            try:
                context.load_verify_locations(self._client_ca)
            except ssl.SSLError as error:
                raise CertificateError(
                    f"{self._client_ca} holds no PEM certificate ({error.reason or error})"
                ) from None
        return context


def load_certificates(settings: Settings) -> Certificates | None:
    """Return the configured certificate; None if the gateway does not speak TLS.

    Raises:
        CertificateError: A file cannot be used.
    """
    if settings.tls_cert is None or settings.tls_key is None:
        return None
    return Certificates(settings.tls_cert, settings.tls_key, settings.tls_client_ca)
