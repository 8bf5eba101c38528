"""Inverse kinematics of six-axis arms and gantries."""
