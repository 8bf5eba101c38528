"""The kinds of YAML file in here, for the reader and the messages that recipes have too."""

from functools import cache

from robotcell.cell.robot_spec import RobotFile
from robotcell.cell.spec import CellSpec
from robotcell.errors import CellError
from specs.yaml.document import Document, Schema


@cache
def cell_model_schema() -> Schema:
    """JSON schema of a cell, as pydantic makes it."""
    return CellSpec.model_json_schema(by_alias=True)


@cache
def robot_model_schema() -> Schema:
    """JSON schema of a robot of the library, as pydantic makes it."""
    return RobotFile.model_json_schema(by_alias=True)


CELL = Document("cell", "cell: NAME", "washboard cell list", CellError, cell_model_schema)
ROBOT = Document("robot", "robot: NAME", "washboard cell list", CellError, robot_model_schema)
