"""Notifications: alerts are sent to webhooks."""
