"""Proves that the text of a program does what was planned, before it is handed out."""

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.steps import MotionProgram
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.proving.agreement import Agreement
from programs.posts.proving.compare import measure
from programs.posts.rebuilt import Rebuilt


def prove(
    dialect: Dialect, files: ProgramFiles, motion: MotionProgram, installation: Installation
) -> tuple[Rebuilt, Agreement]:
    """Read a program back, compare it with the motion it was made from, and give both.

    Args:
        dialect: Its language.
        files: As they were written.
        motion: What ``make_motion`` gave, before it was lowered.
        installation: The cell.

    Raises:
        ProgramError: the text cannot be read, or does something else; the message names the place in the text and what
            was planned there.
    """
    remedy = f"The {dialect.title} writer is at fault: nothing was written. Choose another dialect, and report this."
    try:
        rebuilt = dialect.read(files)
        agreement = measure(rebuilt, motion, installation)
    except ProgramError as refused:
        raise ProgramError(f"{refused} The text cannot be read back. {remedy}") from None
    if agreement.differences:
        first, count = agreement.differences[0], len(agreement.differences)
        counted = "" if count == 1 else f" (first of {count} differences)"
        message = (
            f"the text does not do what was planned at {first.made_by or 'the program'}: {first.message}{counted}."
        )
        place = first.place
        raise ProgramError(f"{message} {remedy}", file=place and place.file, line=place and place.line)
    return rebuilt, agreement
