"""What the scene shows, as arrays and GLB: pure conversions that need no server."""
