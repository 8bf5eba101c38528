"""Recipes of process engineers: functions, nozzles, classes, masks, templates, sequence."""

DISTRIBUTION = "washboard"
