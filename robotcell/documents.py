"""The kinds of YAML file in here, for the reader and the messages that recipes have too."""

from functools import cache

from recipes.document import Document, Schema
from robotcell.errors import CellError
from robotcell.robot_spec import RobotFile
from robotcell.spec import CellSpec


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
