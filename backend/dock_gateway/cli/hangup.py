"""SIGHUP: some settings are read again; where a terminal has closed, the server ends."""

import asyncio
import logging
import os
import signal
from collections.abc import Callable, Iterator

from pydantic_settings import BaseSettings

from dock_gateway.core.log_config import set_log_level
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

# The settings that are read again.
AGAIN = ("log_level", "allow_publish", "allow_services", "allow_parameters")
# Seconds that a terminal may take to close after its signal.
CLOSED_WITHIN = 1.0

Reread = Callable[[], Settings]
OnReread = Callable[[Settings], object]


class Hangup:
    """Handles SIGHUP, unless it is ignored, as `nohup` has it.

    Args:
        settings: The settings of the start.
        reread: Reads them again. Raises a `ValueError` with the reason if they are not valid.
        on_reread: Called with those read again; of them, only `AGAIN` may be taken.
        end: Ends the server.
    """

    def __init__(self, settings: Settings, reread: Reread, on_reread: OnReread, end: Callable[[], object]) -> None:
        self._settings = settings
        self._reread = reread
        self._on_reread = on_reread
        self._end = end
        self._terminals = [*_terminals()]

    def listen(self) -> None:
        """Handle the signal from now on, in the running event loop."""
        if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
            asyncio.get_running_loop().add_signal_handler(signal.SIGHUP, self._on_signal)

    def _on_signal(self) -> None:
        if self._terminal_closed():
            self._end()
            return
        asyncio.get_running_loop().call_later(CLOSED_WITHIN, lambda: self._terminal_closed() and self._end())
        try:
            settings = self._reread()
        except ValueError as error:
            log.error("the settings stay as they are: %s", error)
            return
        set_log_level(settings.log_level)
        self._on_reread(settings)
        changed = [*_changed(self._settings, settings)]
        taken = ", ".join(f"{name} = {_text(getattr(settings, name))}" for name in changed if name in AGAIN)
        log.info("settings are read again: %s", taken or "none of them has changed that can while the gateway runs")
        if later := [name for name in changed if name not in AGAIN]:
            log.warning("changed, and not taken before the next start: %s", ", ".join(later))
        self._settings = settings.model_copy(update={name: getattr(self._settings, name) for name in later})

    def _terminal_closed(self) -> bool:
        return not set(self._terminals) <= set(_terminals())


def _terminals() -> Iterator[int]:
    """Yield the standard streams that are terminals."""
    for number in (0, 1, 2):
        try:
            if os.isatty(number):
                yield number
        except OSError:
            continue


def _changed(before: BaseSettings, after: BaseSettings) -> Iterator[str]:
    for name in type(after).model_fields:
        if getattr(before, name, None) != getattr(after, name):
            yield name


def _text(value: object) -> str:
    return (",".join(value) or "nothing") if isinstance(value, tuple) else str(value)
