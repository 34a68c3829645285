"""What can be done through any door. Each operation is declared once: its role, its subject, its audit."""
