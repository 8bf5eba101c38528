"""Panels of the robot cell: check, reach, joints, program."""
