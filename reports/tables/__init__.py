"""Results as plain data and as rows, in words."""
