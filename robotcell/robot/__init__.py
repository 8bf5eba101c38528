"""Robots from URDF: links, joints, forward kinematics, joint ranges and rates."""
