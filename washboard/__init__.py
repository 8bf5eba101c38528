"""The start of the command `washboard`: signals, and whose the packages are, before anything else is imported."""

DISTRIBUTION = "washboard"
