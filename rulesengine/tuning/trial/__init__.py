"""One trial: what is asked, the run and analysis of a recipe, its open requirements."""
