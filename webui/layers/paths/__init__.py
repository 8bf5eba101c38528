"""Strokes, nozzle, markers and the timeline of events."""
