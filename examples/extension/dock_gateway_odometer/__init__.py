"""How far each robot has driven, and when it is due for service."""
