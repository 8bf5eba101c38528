"""Panels of playback, findings, comparison, output and status."""
