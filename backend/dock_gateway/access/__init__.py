"""Decides who may do what: users, their sessions, tokens, and the streams that end with them."""
