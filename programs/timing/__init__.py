"""Motion over time as controllers make it of a program's lines."""
