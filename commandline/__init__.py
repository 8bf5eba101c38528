"""The command line: one file a command, and the start of `washboard`."""

DISTRIBUTION = "washboard"
