"""Certificates for tests, of a certificate authority that only they trust."""

import ssl
from dataclasses import dataclass, field
from pathlib import Path

import trustme


@dataclass(frozen=True)
class Pair:
    """The files of a certificate and its key."""

    cert: Path
    key: Path

    @property
    def settings(self) -> dict[str, str]:
        """As settings of a gateway."""
        return {"tls_cert": str(self.cert), "tls_key": str(self.key)}


@dataclass(frozen=True)
class Authority:
    """A certificate authority, with its files in a folder."""

    folder: Path
    ca: trustme.CA = field(default_factory=trustme.CA)

    @property
    def file(self) -> Path:
        """Its own certificate."""
        path = self.folder / "ca.pem"
        self.ca.cert_pem.write_to_path(str(path))
        return path

    def issue(self, name: str = "gateway", into: Pair | None = None) -> Pair:
        """Issue a certificate for this machine, in new files or in those of another one."""
        pair = into or Pair(self.folder / f"{name}.pem", self.folder / f"{name}.key")
        issued = self.ca.issue_cert("localhost", "127.0.0.1", common_name=name)
        pair.cert.write_bytes(b"".join(blob.bytes() for blob in issued.cert_chain_pems))
        pair.key.write_bytes(issued.private_key_pem.bytes())
        return pair

    def context(self, own: Pair | None = None) -> ssl.SSLContext:
        """How a client connects that trusts this authority alone, with a certificate of its own or without."""
        context = ssl.create_default_context(cafile=str(self.file))
        if own is not None:
            context.load_cert_chain(own.cert, own.key)
        return context
