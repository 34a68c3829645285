"""How goals ended, by day, robot or action, and how long docking takes."""

from dock_gateway.extension import Core, Extension
from dock_gateway.extensions.statistics.routes import router

extension: Extension[Core] = Extension("statistics", routes=lambda _: (router,))
