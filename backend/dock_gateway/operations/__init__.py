"""Operations that can be done through any door. Each is declared once: its role, its subject, its audit."""
