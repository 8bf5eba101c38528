"""Design variables of a recipe and the edits that change them."""
