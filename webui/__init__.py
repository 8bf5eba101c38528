"""The browser: a recipe is edited, its paths are looked at."""

DISTRIBUTION = "washboard"
