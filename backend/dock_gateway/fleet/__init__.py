"""What spans robots: the overview, alerts, departures and the stop."""
