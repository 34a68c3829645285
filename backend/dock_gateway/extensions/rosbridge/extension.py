"""The door of roslib and what else speaks rosbridge's protocol."""

from dock_gateway.extension import Core, Extension
from dock_gateway.extensions.rosbridge.routes import router

extension: Extension[Core] = Extension("rosbridge", routes=lambda _: (router,))
