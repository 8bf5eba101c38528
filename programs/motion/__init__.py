"""Robot motion from a timed program: lines, events of valves and settings, installation."""
