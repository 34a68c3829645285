"""The protocol of Foxglove: topics, actions, services and parameters for viewers."""
