"""The door of Foxglove and what else speaks its WebSocket protocol."""

from dock_gateway.extension import Core, Extension
from dock_gateway.extensions.foxglove.routes import router

extension: Extension[Core] = Extension("foxglove", routes=lambda _: (router,))
