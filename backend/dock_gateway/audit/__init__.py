"""The record of requests: who did what."""
