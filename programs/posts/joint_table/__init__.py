"""A table of joint values by time."""
