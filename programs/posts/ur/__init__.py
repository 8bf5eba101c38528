"""Universal Robots URScript."""
