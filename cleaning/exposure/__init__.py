"""How much liquid reaches each place of the surface: rays, line of sight, sums by cell."""
