"""The connection of a site to its hub: it says hello, and serves what the hub asks."""
