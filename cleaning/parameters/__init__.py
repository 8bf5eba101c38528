"""Parameter sets of the cleaning model, their provenance, and liquids and air from them."""
