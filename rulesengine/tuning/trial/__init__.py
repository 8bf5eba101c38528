"""One trial: the request, the run and analysis of a recipe, its open requirements."""
