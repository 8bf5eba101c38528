"""Predictions of amounts and times between analyses, by linear programs."""
