"""The base of each group of settings, and where their values come from."""

import os
import tomllib
from pathlib import Path
from typing import Any, ClassVar

from pydantic_settings import (
    BaseSettings,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)

PREFIX = "DOCK_GATEWAY_"
# The variable that names the configuration file.
CONFIG = f"{PREFIX}CONFIG"


def config_file() -> Path | None:
    """Return the configuration file; None if there is none."""
    name = os.environ.get(CONFIG)
    return Path(name) if name else None


def read_file(path: Path) -> dict[str, Any]:
    """Return the settings of a configuration file.

    Raises:
        ValueError: It cannot be read, or is not TOML. The message says which.
    """
    try:
        return tomllib.loads(path.read_text())
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path} is not TOML: {error}") from None


class FileSource(TomlConfigSettingsSource):
    """The configuration file, of which a group takes its own settings."""

    def __init__(self, settings_cls: type[BaseSettings]) -> None:
        super().__init__(settings_cls, config_file())

    def __call__(self) -> dict[str, Any]:
        """Return the values of the group's settings."""
        return {name: value for name, value in self.toml_data.items() if name in self.settings_cls.model_fields}


class SettingsGroup(BaseSettings):
    """Settings that belong together. An option comes before a variable, and that before the configuration file.

    Attributes:
        group: The heading of the group in the help and in docs/configuration.md.
    """

    model_config = SettingsConfigDict(env_prefix=PREFIX, frozen=True, extra="forbid")

    group: ClassVar[str] = ""

    @classmethod
    def settings_customise_sources(
        cls,
        settings_cls: type[BaseSettings],
        init_settings: PydanticBaseSettingsSource,
        env_settings: PydanticBaseSettingsSource,
        dotenv_settings: PydanticBaseSettingsSource,
        file_secret_settings: PydanticBaseSettingsSource,
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Return where values come from, the first one first."""
        return init_settings, env_settings, FileSource(settings_cls)
