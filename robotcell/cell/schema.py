"""The cell's JSON schema for editors, and the table of its keys for people: both made from the model."""

import json

from robotcell.cell.load import CELL
from specs.yaml.schema import DIALECT, key_tables, schema_parts

_SHAPES = ("BoxSpec", "CapsuleSpec", "CylinderSpec", "HoseSpec", "MeshSpec")
_SECTIONS = {
    "The cell": ("CellSpec",),
    "base, tcp, pose, at": ("Place",),
    "robot, where it is not of the library": ("RobotSpec",),
    "joints": ("JointLimits",),
    "board, placements": ("Hold",),
    "board: points": ("PointPair",),
    "board: touched": ("Touched",),
    "tools": ("ToolSpec",),
    "tools: bodies, and fixtures": _SHAPES,
    "nozzles": ("NozzleSpec",),
    "io": ("InputOutput",),
    "io: outputs": ("Output",),
    "io: settings": ("OutputSetting",),
    "io: sensors": ("Sensor",),
    "io: grip": ("Grip",),
}


def cell_schema() -> str:
    """Write the JSON schema of a cell's file, with a line feed at the end."""
    schema = {
        "$schema": DIALECT,
        "title": "Washboard cell",
        **{key: value for key, value in CELL.schema().items() if key not in ("title", "$defs")},
        "$defs": schema_parts(CELL),
    }
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def cell_keys() -> str:
    """Write every key of a cell as Markdown."""
    return key_tables(CELL, _SECTIONS)
