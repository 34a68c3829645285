"""Counts goals by their ends, by day, robot or action, and measures how long docking takes."""

from dock_gateway.extension import Extension
from dock_gateway.extensions.statistics.routes import router

extension = Extension("statistics", routes=lambda _: (router,))
