"""Package families: what a package name says of size, height and standoff."""
