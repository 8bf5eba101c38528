"""Recipe and board to plan: strokes in order, transfers, the whole run."""
