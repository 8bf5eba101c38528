"""The cell's JSON schema for editors, and the table of its keys for people: both made from the model."""

import json
from typing import cast

from robotcell.cell.documents import cell_model_schema
from specs.yaml.document import Schema
from specs.yaml.key_tables import require_kind, write_tables

_DIALECT = "https://json-schema.org/draft/2020-12/schema"
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
    "io: settings": ("Setting",),
    "io: sensors": ("Sensor",),
    "io: grip": ("Grip",),
}


def cell_schema() -> str:
    """Write the JSON schema of a cell's file, with a line feed at the end."""
    whole = cell_model_schema()
    schema = {
        "$schema": _DIALECT,
        "title": "Washboard cell",
        **{key: value for key, value in whole.items() if key not in ("title", "$defs")},
        "$defs": _parts(),
    }
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def cell_keys() -> str:
    """Write every key of a cell as Markdown."""
    heading = "# Every key of a cell\n\nMade by `washboard cell keys`; units are in the names."
    return write_tables(heading, {**_parts(), "CellSpec": cell_model_schema()}, _SECTIONS)


def _parts() -> dict[str, Schema]:
    parts = cast("dict[str, Schema]", cell_model_schema()["$defs"])
    return {name: require_kind(part) for name, part in parts.items()}
