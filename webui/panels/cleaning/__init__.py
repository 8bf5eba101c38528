"""Panels of the cleaning prediction and of tuning."""
