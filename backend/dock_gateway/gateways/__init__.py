"""The gateways that share a database: which of them serves which robots."""
