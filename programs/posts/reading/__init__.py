"""Exported programs read back and compared with the motion they were made from."""
