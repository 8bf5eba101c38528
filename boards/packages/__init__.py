"""Package families: what a package name says of size, height and gap height, and the gap height that counts."""
