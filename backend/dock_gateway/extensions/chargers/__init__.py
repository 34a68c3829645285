"""Docks that several robots share: at most one robot has each of them."""
