"""The recipe's JSON schema for editors, and the table of its keys for people: both made from the model."""

from typing import get_args

from recipes.load import RECIPE
from recipes.nozzles import NOZZLE_PATTERNS
from recipes.paths import PATH_CLASSES
from specs.spec import Spec
from specs.yaml.schema import extending_schema, key_tables

_SECTIONS = {
    "The recipe": ("Recipe",),
    "functions": ("Function",),
    "nozzles": tuple(nozzle.__name__ for nozzle in NOZZLE_PATTERNS),
    "nozzles: wavefront of a hollow_cone": ("Wavefront",),
    "classes": ("ComponentClass",),
    "classes: pins, area_mm2, height_mm, standoff_mm, neighbour_mm": ("Range",),
    "masks": ("Mask",),
    "templates": tuple(spec.__name__ for spec in PATH_CLASSES),
    **{  # the parts that templates have, by key and path class
        f"templates: {key} of a {spec.model_fields['path'].default}": (part.__name__,)
        for spec in PATH_CLASSES
        for key, field in spec.model_fields.items()
        for part in get_args(field.annotation)
        if isinstance(part, type) and issubclass(part, Spec)
    },
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
