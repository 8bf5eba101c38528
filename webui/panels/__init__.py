"""What stands beside the scene: each panel shows a session and edits it."""
