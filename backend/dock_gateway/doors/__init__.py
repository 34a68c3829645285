"""REST: each endpoint decodes what a client sends, calls an operation, and encodes its answer.

The other doors are `streams` (SSE, `/ws`) and extensions.
"""
