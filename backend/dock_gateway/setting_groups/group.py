"""The base of each group of settings."""

from typing import ClassVar

from pydantic_settings import BaseSettings, SettingsConfigDict

PREFIX = "DOCK_GATEWAY_"


class SettingsGroup(BaseSettings):
    """Settings that belong together.

    Attributes:
        group: The heading of the group in the help and in docs/configuration.md.
    """

    model_config = SettingsConfigDict(env_prefix=PREFIX, frozen=True, extra="forbid")

    group: ClassVar[str] = ""
