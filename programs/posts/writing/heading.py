"""What every exported program says about itself, whatever the language's comments look like."""

from programs.motion.analog import analog_channels
from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.posts.writing.wording import plain

_MOST_FINDINGS = 12


def heading(lowered: Lowered, installation: Installation, capability: Capability, title: str) -> tuple[str, ...]:
    """Give the lines of a program's header without comment marks: printable ASCII, of any length.

    It has no date and no path, so that the same program gives the same bytes.
    """
    motion, error = lowered.motion, lowered.error
    origin = motion.origin
    said = [f"{finding.severity}: {finding.message}" for finding in motion.findings if finding.severity != "info"]
    lines = (
        f"{title}, written by Washboard",
        f"Board  {origin.board}  sha256 {origin.board_sha256}",
        f"Recipe {origin.recipe}  sha256 {origin.recipe_sha256}",
        f"Cell   {installation.cell}  robot {installation.robot}",
        f"Planned time {motion.duration_s:.1f} s, each loop once",
        f"Worst event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms at planned speeds"
        + (f" ({error.made_by})" if error.made_by else ""),
        f"Controller class {capability.controller_class}; cycle {1e3 * capability.cycle_s:g} ms is in the error",
        *(f"Analog {capability.analog.describe(channel)}" for channel in analog_channels(motion.steps)),
        *said[:_MOST_FINDINGS],
        *([f"and {len(said) - _MOST_FINDINGS} findings more"] if len(said) > _MOST_FINDINGS else []),
    )
    return tuple(plain(line) for line in lines)
