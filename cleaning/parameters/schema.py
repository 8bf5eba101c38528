"""The parameter set's JSON schema for editors, and the table of its keys for people: both made from the model."""

from cleaning.parameters.load import PARAMETERS
from specs.yaml.schema import extending_schema, key_tables

_SECTIONS = {
    "The set": ("Parameters",),
    "spray": ("Spray",),
    "liquids": ("Liquid",),
    "soil": ("Soil",),
    "film": ("Film",),
    "gap": ("Gap",),
    "rinse": ("Rinse",),
    "rinse: cascade": ("RinseCascade",),
    "rinse: cascade: tanks": ("RinseTank",),
    "drying": ("Drying",),
    "parts": ("PartOverride",),
    "limits": ("Limits",),
    "provenance": ("Provenance",),
}


def parameters_schema() -> str:
    """Write the JSON schema of a parameter set's file, with a line feed at the end."""
    means = "Inputs of the cleaning model besides board and recipe, and how each value is known."
    return extending_schema(PARAMETERS, means)


def parameters_keys() -> str:
    """Write every key of a parameter set as Markdown."""
    return key_tables(PARAMETERS, _SECTIONS)
