"""LinuxCNC G-code."""
