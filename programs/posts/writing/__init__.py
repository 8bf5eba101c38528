"""What the writers of robot languages share."""
