"""Meshes and ribbons as binary glTF, with colours."""
