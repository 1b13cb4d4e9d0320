"""What robots look like where their collision shapes do not tell."""
