"""The HTTP and WebSocket edge below the routes: limits on connections and input, and timeouts.

uvicorn and its libraries speak the protocols; this package limits what one client can take from the others.
"""
