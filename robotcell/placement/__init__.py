"""Reachability and the best place of the board."""
