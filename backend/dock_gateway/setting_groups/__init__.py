"""The groups of the settings, each a module."""
