"""Carries HTTP requests and WebSockets from a hub to the ASGI app of a site."""
