"""What the dashboard costs the computer that it is open on."""
