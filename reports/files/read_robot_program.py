"""Programs in robots' languages, read with the cell that they were written for."""

from collections.abc import Mapping
from pathlib import Path

from programs.errors import ProgramError
from programs.foreign import named_cell, rebuild_program
from programs.program import TimedProgram
from robotcell.cell.installation import flange_of, installation_of
from robotcell.cell.load import LoadedCell, cell_library, read_cell


def find_cell(files: Mapping[str, str], place: Path, advice: str) -> LoadedCell:
    """Read the library cell that the header of a program names.

    Args:
        files: Text by file name.
        place: Of the program, for the error.
        advice: How the cell is named otherwise, for the error.

    Raises:
        ProgramError: none is named, or it is not in the library.
    """
    name = named_cell(files)
    if name not in cell_library():
        named = f"made for cell {name}, which is not in the library" if name else "no cell is named in its header"
        raise ProgramError(f"{named}; {advice}", file=place)
    return read_cell(name)


def rebuild_in_cell(dialect: str, files: Mapping[str, str], loaded: LoadedCell) -> TimedProgram:
    """Execute the text of a program with the tools, valves and kinematics of a cell.

    Raises:
        ProgramError: it is not understood, or was made for another robot.
    """
    return rebuild_program(dialect, files, installation_of(loaded), flange_of(loaded.cell))
