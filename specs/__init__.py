"""Typed YAML with lines and comments kept; findings, errors, progress. Knows no numpy and no noun."""

DISTRIBUTION = "washboard"
