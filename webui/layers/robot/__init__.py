"""The robot, its joints over time, and where it comes near."""
