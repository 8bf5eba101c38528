"""Reading parameter sets, from the library by name or from a file; their JSON schema, and the table of their keys."""

from dataclasses import dataclass
from pathlib import Path

from cleaning.errors import CleaningError
from cleaning.parameters.model import Parameters
from cleaning.parameters.provenance import find_problems
from specs.json import content_sha256
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, parse_spec, read_text, resolve_text
from specs.yaml.located import Located
from specs.yaml.problems import raise_problems
from specs.yaml.schema import extending_schema, key_tables

_LIBRARY = Path(__file__).parents[1] / "library"


def parameter_library() -> dict[str, Path]:
    """Give the parameter sets that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


PARAMETERS = FileKind(
    "parameter set",
    "parameters: NAME",
    "washboard parameters",
    CleaningError,
    Parameters,
    parameter_library,
    named=frozenset({"liquids", "provenance"}),
)


@dataclass(frozen=True, slots=True)
class LoadedParameters:
    """A parameter set and where each of its values was written."""

    parameters: Parameters
    root: Located
    """The resolved tree: a value that was inherited bears the mark of the file it stands in."""


def load_parameters(source: str | Path = "default") -> Parameters:
    """Read a parameter set.

    Args:
        source: A name of the library such as ``default``, or a file.

    Raises:
        CleaningError: it cannot be found or used; the message states where and what to do.
    """
    return read_parameters(source).parameters


def read_parameters(source: str | Path = "default") -> LoadedParameters:
    """Read a parameter set as ``load_parameters`` does and keep where its values stand.

    Raises:
        CleaningError: it cannot be found or used.
    """
    path = find_file(source, PARAMETERS)
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
    root = resolve_text(text, file, PARAMETERS)
    described = root.get("description")
    if described is not None and described.mark.file != root.mark.file and isinstance(root.value, dict):
        # It was inherited, and describes another set.
        root = Located({key: node for key, node in root.value.items() if key != "description"}, root.mark, root.removed)
    parameters = parse_spec(root, PARAMETERS)
    raise_problems(find_problems(parameters, root), root, PARAMETERS)
    return LoadedParameters(parameters, root)


def parameters_sha256(parameters: Parameters) -> str:
    """Hash the content of a set, however it was written: inherited or not, in whatever order."""
    return content_sha256(parameters.model_dump(mode="json", exclude={"extends"}))


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
