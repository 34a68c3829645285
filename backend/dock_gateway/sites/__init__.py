"""The common part of a site and its hub: subjects and messages on the broker, the tunnel, names and identities."""
