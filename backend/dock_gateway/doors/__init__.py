"""Doors: each decodes what a client sends, calls an operation, and encodes its answer."""
