"""The audit log: who did what, in a chain of digests that shows whether it was changed."""
