"""YAML read with the place of every value, inherited, edited in place, and its keys explained."""
