"""How a face is divided into stripes: one file a member of the family."""
