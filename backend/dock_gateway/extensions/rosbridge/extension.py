"""The door of roslib and what else speaks rosbridge's protocol."""

from dock_gateway.extension import Extension
from dock_gateway.extensions.rosbridge.routes import router
from dock_gateway.extensions.rosbridge.settings import RosbridgeSettings

extension = Extension("rosbridge", settings=RosbridgeSettings, routes=lambda _: (router,))
