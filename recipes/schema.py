"""The recipe's JSON schema for editors, and the table of its keys for people: both made from the model."""

from recipes.load import RECIPE
from specs.yaml.schema import extending_schema, key_tables

_SECTIONS = {
    "The recipe": ("Recipe",),
    "functions": ("Function",),
    "nozzles": ("HollowCone", "FullCone", "FlatFan", "AirKnife"),
    "nozzles: wavefront of a hollow_cone": ("Wavefront",),
    "classes": ("ComponentClass",),
    "classes: pins, area_mm2, height_mm, standoff_mm, neighbour_mm": ("Range",),
    "masks": ("Mask",),
    "templates": ("BoardPerimeter", "Raster", "ComponentPerimeter", "FinalFlush", "StepFunction", "StraightLine"),
    "templates: near of a component_perimeter": ("Near",),
    "limits": ("Limits",),
    "sequence": ("Step",),
    "sequence: until": ("Until",),
}


def recipe_schema() -> str:
    """Write the JSON schema of a recipe file, with a line feed at the end."""
    means = "The recipe of a process engineer: functions, nozzles, classes, masks, templates, sequence."
    return extending_schema(RECIPE, means)


def recipe_keys() -> str:
    """Write every key of a recipe as Markdown: one table for each part, with defaults and descriptions."""
    return key_tables(RECIPE, _SECTIONS)
