"""The parameter set's JSON schema for editors, and the table of its keys for people: both made from the model."""

from typing import cast

from cleaning.parameters.load import parameters_model_schema
from recipes.schema import extending_schema
from specs.yaml.document import Schema
from specs.yaml.key_tables import write_tables

_SECTIONS = {
    "The set": ("Parameters",),
    "spray": ("Spray",),
    "liquids": ("Liquid",),
    "soil": ("Soil",),
    "film": ("Film",),
    "gap": ("Gap",),
    "rinse": ("Rinse",),
    "drying": ("Drying",),
    "parts": ("PartOverride",),
    "limits": ("Limits",),
    "provenance": ("Provenance",),
}


def parameters_schema() -> str:
    """Write the JSON schema of a parameter set's file, with a line feed at the end."""
    means = "What the cleaning model must be told besides board and recipe, and how each value is known."
    return extending_schema("Parameters", parameters_model_schema(), "Washboard parameter set", means)


def parameters_keys() -> str:
    """Write every key of a parameter set as Markdown."""
    whole = parameters_model_schema()
    parts = {**cast("dict[str, Schema]", whole["$defs"]), "Parameters": whole}
    heading = "# Every key of a parameter set\n\nMade by `washboard parameters keys`; units are in the names."
    return write_tables(heading, parts, _SECTIONS)
