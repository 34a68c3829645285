"""The settings of the server: where it listens, for whom, and what it logs."""

from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from dock_gateway.setting_groups.group import SettingsGroup
from dock_gateway.setting_types import TUNING, ExtensionNames, HostNames, ListensOn, Networks, OptionalFile, Origins


class ServerSettings(SettingsGroup):
    """The settings of the server: where it listens, for whom, and what it logs."""

    group: ClassVar[str] = "Server"

    host: str = Field("127.0.0.1", description="Address to listen on. `0.0.0.0` opens the gateway to the network.")
    port: Annotated[int, ListensOn()] = Field(
        8000, ge=0, le=65535, description="Port to listen on; 0 selects a free port."
    )
    allowed_hosts: HostNames = Field(
        (),
        description="Host names that requests may be addressed to, such as `robot.local`, separated by commas; `*` "
        "for any. Loopback names and IP addresses are always allowed.",
    )
    allowed_origins: Origins = Field(
        (),
        description="Origins of web pages that may use the gateway besides its own dashboard, "
        "separated by commas (`https://ops.example.com`); `*` for any.",
    )
    trusted_proxies: Networks = Field(
        (),
        description="IP addresses and networks (`10.0.0.0/8`) of reverse proxies, separated by commas: "
        "`127.0.0.1,::1` for one on this machine. Only their `X-Forwarded-Proto` and `X-Forwarded-For` are believed.",
    )
    published_on: str = Field(
        "",
        description="In a container: the address of the host on which its port is published. It takes the place of "
        "`HOST` in deciding whether the gateway is open to a network.",
    )
    tls_cert: OptionalFile = Field(
        None,
        description="PEM file with the gateway's certificate and its intermediates. With it, the gateway speaks only "
        "TLS: [deployment.md](deployment.md#tls).",
    )
    tls_key: OptionalFile = Field(
        None, description="PEM file with the private key of `TLS_CERT`, without a passphrase."
    )
    tls_client_ca: OptionalFile = Field(
        None,
        description="PEM file with certificate authorities. Only clients with a certificate of theirs can connect.",
    )
    log_level: str = Field(
        "info",
        pattern="^(debug|info|warning|error)$",
        description="Log level. At most 20 similar lines are logged in 10 s and the rest are counted, except with "
        "`debug`.",
    )
    log_format: Literal["human", "json"] = Field(
        "human", description="Format of log lines: `human`, or `json` for a log collector: [logs.md](logs.md)."
    )
    extensions: ExtensionNames = Field(
        (),
        description="Extensions of other distributions that are loaded, separated by commas; only as a variable: "
        "[write-an-extension.md](write-an-extension.md).",
    )
    dashboard_dir: Annotated[Path | None, TUNING] = Field(
        None,
        description="Folder of the built dashboard. Empty: the installed one, or `frontend/dist` in a checkout.",
    )

    @model_validator(mode="after")
    def _check_tls(self) -> Self:
        if (self.tls_cert is None) != (self.tls_key is None):
            raise ValueError("tls_cert and tls_key belong together: set both or neither")
        if self.tls_client_ca is not None and not self.tls_cert:
            raise ValueError("tls_client_ca needs tls_cert and tls_key")
        return self
