"""What can be a part, by its name alone: recognised without the libraries that read one."""

from pathlib import Path

from boards.load import is_panel_file
from specs.yaml.load import is_bare

TEXT_SUFFIXES = (".xyz", ".txt")
"""Of a cloud of points."""
MESH_SUFFIXES = (".stl", ".obj", ".ply", ".step", ".stp", ".glb", ".gltf")
PART_SUFFIXES = (".yaml", ".yml", ".tri", ".tri.gz", *MESH_SUFFIXES, *TEXT_SUFFIXES)
"""What the name of a part's file may end with."""

_LIBRARY = Path(__file__).parent / "library"


def part_library() -> dict[str, Path]:
    """Give the parts that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


def is_part_source(source: str | Path) -> bool:
    """Whether a source can be nothing but a part: a name of the parts' library, a cloud, or a YAML file of no panel."""
    text = str(source)
    if (is_bare(text) and text in part_library()) or text.lower().endswith(TEXT_SUFFIXES):
        return True
    return text.lower().endswith((".yaml", ".yml")) and not is_panel_file(Path(text))
