"""Panels beside the scene, which show a session and edit it."""
