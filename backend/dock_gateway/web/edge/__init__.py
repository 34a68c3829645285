"""The HTTP and WebSocket edge below the routes: who may connect, how much is read, and when it is cut off.

uvicorn and its libraries speak the protocols; this package bounds what one client can take from the others.
"""
