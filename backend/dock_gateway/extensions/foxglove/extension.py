"""The door of Foxglove and what else speaks its WebSocket protocol."""

from dock_gateway.extension import Extension
from dock_gateway.extensions.foxglove.error_codes import CODES
from dock_gateway.extensions.foxglove.routes import router
from dock_gateway.extensions.foxglove.settings import FoxgloveSettings

extension = Extension("foxglove", settings=FoxgloveSettings, routes=lambda _: (router,), errors=CODES)
