"""Reading parameter sets: from the library by name, or from a file."""

import hashlib
import json
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pydantic import ValidationError

from cleaning.errors import CleaningError
from cleaning.parameters.consistency import find_problems
from cleaning.parameters.model import Parameters
from specs.yaml.document import Document, Schema
from specs.yaml.files import find_file, is_bare, read_text
from specs.yaml.inherit import inherit
from specs.yaml.located import Located, read_yaml
from specs.yaml.problems import raise_problems, translate

_LIBRARY = Path(__file__).parents[1] / "library"


@dataclass(frozen=True, slots=True)
class LoadedParameters:
    """A parameter set and where each of its values was written."""

    parameters: Parameters
    root: Located
    """The resolved tree: a value that was inherited bears the mark of the file it stands in."""


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
    return read_parameters(source).parameters


def read_parameters(source: str | Path = "default") -> LoadedParameters:
    """Read a parameter set as ``load_parameters`` does and keep where its values stand.

    Raises:
        CleaningError: it cannot be found or used.
    """
    path = find_parameters(source)
    return locate_parameters(read_text(path, PARAMETERS), file=path)


def read_parameters_text(text: str, *, file: Path | str = "<parameters>") -> Parameters:
    """Read a parameter set from its YAML text; a file that it extends is looked for beside it.

    Raises:
        CleaningError: it cannot be used.
    """
    return locate_parameters(text, file=file).parameters


def locate_parameters(text: str, *, file: Path | str = "<parameters>") -> LoadedParameters:
    """Read a parameter set from its text as ``read_parameters_text`` does and keep where its values stand.

    Raises:
        CleaningError: it cannot be used.
    """
    root = _described_by_itself(inherit(read_yaml(text, file, PARAMETERS), _read_extended, PARAMETERS))
    try:
        # JSON is what makes pydantic strict about types while lists still become tuples.
        parameters = Parameters.model_validate_json(json.dumps(root.plain()), strict=True)
    except ValidationError as error:
        raise_problems(translate(error, root, PARAMETERS), root, PARAMETERS)
        raise AssertionError("a refused parameter set has a problem") from error
    raise_problems(find_problems(parameters, root), root, PARAMETERS)
    return LoadedParameters(parameters, root)


def _described_by_itself(root: Located) -> Located:
    """Leave out a description that was inherited: it is of another set."""
    described = root.get("description")
    if described is None or described.mark.file == root.mark.file or not isinstance(root.value, dict):
        return root
    return Located({key: node for key, node in root.value.items() if key != "description"}, root.mark)


def parameters_sha256(parameters: Parameters) -> str:
    """Hash what a set says, however it was written: inherited or not, in whatever order."""
    content = parameters.model_dump(mode="json", exclude={"extends"})
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def find_parameters(source: str | Path) -> Path:
    """Find the file of a parameter set: a library name first, then a path.

    Raises:
        CleaningError: a bare name that is neither in the library nor a file.
    """
    return find_file(source, parameter_library(), PARAMETERS)


def _read_extended(name: str, where: Located) -> Located:
    """Read the tree of the set that another one extends; a relative path starts at the folder of that other."""
    try:
        path = parameter_library().get(name)
        if path is None and is_bare(name):
            find_parameters(name)
        path = path or Path(os.path.normpath(Path(where.mark.file).parent / name))
        text = read_text(path, PARAMETERS)
    except CleaningError as error:
        raise CleaningError(str(error), path="extends", file=where.mark.file, line=where.mark.line) from None
    return read_yaml(text, path, PARAMETERS)
