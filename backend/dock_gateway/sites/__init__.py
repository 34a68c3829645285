"""What a site and its hub both need: subjects and messages on the broker, the tunnel, names, and who asks."""
