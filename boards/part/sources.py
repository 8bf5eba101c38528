"""What can be a part, by its name alone: recognised without the libraries that read one."""

from pathlib import Path

from boards.formats.table import is_marked, suffixes_of
from boards.load import is_panel_file
from specs.yaml.load import is_bare

MESH_SUFFIXES = suffixes_of("tree")
CLOUD_SUFFIXES = tuple(suffix for suffix in suffixes_of("points") if suffix not in MESH_SUFFIXES)
"""Of a cloud of points, and of nothing else."""
PART_SUFFIXES = (".yaml", ".yml", ".tri", ".tri.gz", *MESH_SUFFIXES, *CLOUD_SUFFIXES)
"""What the name of a part's file may end with."""

_LIBRARY = Path(__file__).parent / "library"


def part_library() -> dict[str, Path]:
    """Give the parts that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


def is_part_source(source: str | Path) -> bool:
    """Whether a source can be nothing but a part: a name of its library, a cloud, or a YAML file of no panel.

    A text of points may be a board by the mark of its format.
    """
    text = str(source)
    if text.lower().endswith(CLOUD_SUFFIXES):
        return not is_marked(Path(text))
    if is_bare(text) and text in part_library():
        return True
    return text.lower().endswith((".yaml", ".yml")) and not is_panel_file(Path(text))
