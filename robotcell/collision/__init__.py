"""Distances and collisions of robot, tool, board and cell."""
