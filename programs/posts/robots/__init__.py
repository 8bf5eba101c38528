"""Languages of robots: one module each, what writes it and what reads it back."""
