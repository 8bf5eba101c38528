"""Reading parameter sets: from the library by name, or from a file."""

import json
from functools import cache
from pathlib import Path

from pydantic import ValidationError

from cleaning.errors import CleaningError
from cleaning.parameters import Parameters
from recipes.document import Document, Schema
from recipes.files import find_file, read_text
from recipes.located import read_yaml
from recipes.problems import raise_problems, translate

_LIBRARY = Path(__file__).parent / "library"


@cache
def parameters_model_schema() -> Schema:
    """JSON schema of a parameter set, as pydantic makes it."""
    return Parameters.model_json_schema(by_alias=True)


PARAMETERS = Document(
    "parameter set", "parameters: NAME", "washboard parameters list", CleaningError, parameters_model_schema
)


def parameter_library() -> dict[str, Path]:
    """Give the parameter sets that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


def load_parameters(source: str | Path = "default") -> Parameters:
    """Read a parameter set.

    Args:
        source: A name of the library such as ``default``, or a file.

    Raises:
        CleaningError: it cannot be found or used; the message says where and what to do.
    """
    path = find_file(source, parameter_library(), PARAMETERS)
    return read_parameters_text(read_text(path, PARAMETERS), file=path)


def read_parameters_text(text: str, *, file: Path | str = "<parameters>") -> Parameters:
    """Read a parameter set from its YAML text.

    Raises:
        CleaningError: it cannot be used.
    """
    root = read_yaml(text, file, PARAMETERS)
    try:
        # JSON is what makes pydantic strict about types while lists still become tuples.
        return Parameters.model_validate_json(json.dumps(root.plain()), strict=True)
    except ValidationError as error:
        raise_problems(translate(error, root, PARAMETERS), root, PARAMETERS)
        raise AssertionError("a refused parameter set has a problem") from error
