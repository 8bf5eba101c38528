"""Layers of the scene as arrays and GLB: pure conversions that need no server."""
