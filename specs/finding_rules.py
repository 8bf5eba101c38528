"""Every finding rule once: its id, its severity, its meaning, and the page of ``docs`` that lists it.

Verdicts of the cleaning model become findings too; their rules are derived from the rules where they are reported.
"""

import difflib
from collections.abc import Iterable
from dataclasses import dataclass

from specs.errors import JobError
from specs.finding import FindingRule, Severity


@dataclass(frozen=True, slots=True)
class _Page:
    """A page of ``docs`` whose table lists the rules that it makes, by their severity."""

    name: str

    def error(self, id_: str, meaning: str, also: Severity | None = None) -> FindingRule:
        return FindingRule(id_, "error", meaning, self.name, also)

    def warning(self, id_: str, meaning: str, also: Severity | None = None) -> FindingRule:
        return FindingRule(id_, "warning", meaning, self.name, also)

    def info(self, id_: str, meaning: str, also: Severity | None = None) -> FindingRule:
        return FindingRule(id_, "info", meaning, self.name, also)


_BOARDS = _Page("boards.md")
_CELLS = _Page("cells.md")
_CHECKING = _Page("checking.md")
_CLEANING = _Page("cleaning.md")
_PLANNING = _Page("planning.md")
_PROGRAMS = _Page("robot-programs.md")
_RECIPE = _Page("recipe.md")
_SURFACES = _Page("surfaces.md")

# Boards: how a file was read, and whether the board makes sense.
TRI_LEGACY = _BOARDS.info("tri-legacy", "a `.tri` file holds numbers only: mm and the largest object assumed")
TRI_DEGENERATE = _BOARDS.warning("tri-degenerate", "patches without an area were left out")
TRI_ZERO_NORMAL = _BOARDS.warning("tri-zero-normal", "a normal has zero length; that of the winding was taken")
TRI_NORMAL = _BOARDS.warning("tri-normal", "a normal is more than 90 degrees away from its winding")
UNIT_GUESSED = _BOARDS.warning(
    "unit-guessed", "the board's size fits another unit than the format's; that unit was taken"
)
BOARD_TURNED = _BOARDS.info("board-turned", "the board did not lie in the x/y plane and was turned")
BOARD_NOT_TURNED = _BOARDS.info("board-not-turned", "a glTF file has y up, but its board lies in the x/y plane already")
NO_COMPONENTS = _BOARDS.warning("no-components", "the file holds nothing but the board")
PART_WITHOUT_GEOMETRY = _BOARDS.warning(
    "part-without-geometry", "parts of a STEP file or of a placement table have no geometry and are missing"
)
BOARD_LAYERS = _BOARDS.info("board-layers", "bodies within the board's thickness were left out")
COMPONENT_WITHOUT_HEIGHT = _BOARDS.warning(
    "component-without-height", "named parts have no height above the board and were left out"
)
NOT_ON_THE_BOARD = _BOARDS.warning("not-on-the-board", "bodies do not stand on the board and were kept as obstacles")
MODELS_JOINED = _BOARDS.info("models-joined", "touching bodies of one name became one component")
REPEATED_NAME = _BOARDS.warning("repeated-name", "components share a reference designator and were renamed")
NO_BODY = _BOARDS.info("no-body", "footprints or placed objects without a body were left out")
IDF_UNPLACED = _BOARDS.info("idf-unplaced", "an IDF file has components that are not placed yet")
SMALL_DRILLS = _BOARDS.info("small-drills", "small drilled holes were left out of the outline")
DOUBTFUL_HEIGHT = _BOARDS.warning(
    "doubtful-height", "stated heights contradict the packages, or are a layout tool's default"
)
KICAD_VERSION = _BOARDS.warning("kicad-version", "the file is of a KiCad version that is not known")
EAGLE_VERSION = _BOARDS.warning("eagle-version", "the file is of an Eagle version that is not known")
OPEN_EDGE = _BOARDS.warning("open-edge", "lines of the board's edge enclose nothing and were left out")
ASSUMED_HEIGHT = _BOARDS.warning("assumed-height", "components of no known package family were assumed tall")
OUTLINE_FROM_PADS = _BOARDS.warning(
    "outline-from-pads", "footprints without a drawing: the box around their pads is their body"
)
BOARD_IN_PIECES = _BOARDS.warning("board-in-pieces", "the bare board consists of several pieces")
ALL_ON_BOTTOM = _BOARDS.warning("all-on-bottom", "every component lies on the bottom side")
COMPONENT_OUTSIDE = _BOARDS.warning("component-outside", "a component lies more than 5 mm outside the board's outline")
COMPONENT_FLOATING = _BOARDS.warning(
    "component-floating", "a component is more than 5 mm away from the board's surface"
)
COMPONENT_SUNK = _BOARDS.warning(
    "component-sunk", "less than half of a component's surface lies above its side of the board"
)
PARTS_BY_POSITION = _BOARDS.info(
    "parts-by-position", "rows of the parts table were joined by position instead of by name"
)
PARTS_FRAME = _BOARDS.info(
    "parts-frame", "positions of the parts table were turned, mirrored or moved to fit the board"
)
PARTS_POSITION = _BOARDS.warning("parts-position", "positions of the parts table do not fit those of the components")
PARTS_NOT_ON_BOARD = _BOARDS.warning("parts-not-on-board", "rows of the parts table have no component on the board")
PARTS_NOT_IN_TABLE = _BOARDS.warning("parts-not-in-table", "components have no row in the parts table")
PARTS_CONTRADICT = _BOARDS.warning("parts-contradict", "entries of the parts table contradict the board file")

# Recipes: what is allowed but probably not meant.
UNUSED_FUNCTION = _RECIPE.warning("unused-function", "no step uses this function")
UNUSED_NOZZLE = _RECIPE.warning("unused-nozzle", "no step uses this nozzle")
UNUSED_TEMPLATE = _RECIPE.warning("unused-template", "no step uses this template")
CLASS_OUT_OF_REACH = _RECIPE.warning("class-out-of-reach", "a class before it takes every component")
NO_CLASS_FOR_THE_REST = _RECIPE.warning("no-class-for-the-rest", "no class takes what the others leave")
NEAR_WITHIN_MERGE_GAP = _RECIPE.warning(
    "near-within-merge-gap", "components so close are followed as one outline, so `near` seldom holds"
)
RING_CONTRADICTS_HALF_ANGLE = _RECIPE.warning(
    "ring-contradicts-half-angle", "the measured wave front and `half_angle_deg` differ by more than 8 degrees"
)

RINSE_BEFORE_CLEAN = _RECIPE.warning("rinse-before-clean", "a step rinses before the first step that washes the board")

# Planning.
CLASS_EMPTY = _PLANNING.info("class-empty", "a class has no member on this board")
MASK_EMPTY = _PLANNING.warning("mask-empty", "a mask's pattern matches nothing")
MASK_CONFLICT = _PLANNING.error("mask-conflict", "a component is to be avoided and to be cleaned")
NOT_SERVED = _PLANNING.error(
    "not-served", "a component that must be cleaned is on a side that no step sprays, or no pass goes around it"
)
LEAST_TIME_MISSED = _PLANNING.warning(
    "least-time-missed", "a step sprays for less than its least time, and no repeat of its last path helps"
)
SIDE_NOT_SPRAYED = _PLANNING.warning(
    "side-not-sprayed",
    "components of a side are not sprayed: no step has this side, or paths around components alone leave them "
    "out. An error where only the other side is sprayed, which has no components",
    also="error",
)
WAVEFRONT_BEHIND_NOZZLE = _PLANNING.warning("wavefront-behind-nozzle", "the tilt is smaller than the half angle")
NO_PATH_INSIDE = _PLANNING.warning("no-path-inside", "a path that far inside the outline does not exist")
NOT_CIRCLED = _PLANNING.warning(
    "not-circled", "a path inside the outline of a group leaves some of its components outside"
)
NARROW_CORRIDOR = _PLANNING.info("narrow-corridor", "neighbours stand closer than the cone is wide")
SPRAY_BESIDE_BOARD = _PLANNING.info(
    "spray-beside-board", "less than half of the spray of a template lands on the board"
)
MARGIN_REDUCED = _PLANNING.info("margin-reduced", "the margin leaves nothing of a narrow board")
PITCH_TOO_WIDE = _PLANNING.warning("pitch-too-wide", "a stated pitch leaves strips uncovered")
RAISED_OVER_BODY = _PLANNING.warning("raised-over-body", "a stroke was raised to keep its clearance")
CUT_BY_MASK = _PLANNING.info(
    "cut-by-mask",
    "strokes were cut to keep the wave front off what is avoided; a warning where whole strokes or a tenth are lost",
    also="warning",
)
LEAD_IN_BLOCKED = _PLANNING.info("lead-in-blocked", "no room for a run-up")
ORDER_GAIN = _PLANNING.info("order-gain", "what the order of strokes saved")
SPEED_BELOW_PROGRAMMED = _PLANNING.warning(
    "speed-below-programmed",
    "the programmed speed is not reached while spraying; a note where that is so on less than half of the length",
    also="info",
)

ROBOT_LIMITS = _PLANNING.warning(
    "robot-limits",
    "with a cell: the robot cannot carry out the program, or takes more than 1.05 times the planned time. A note "
    "otherwise: what its limits cost against those of the recipe alone, by kind of motion",
    also="info",
)

# Cells: what is probably not meant.
TCP_UNITS = _CELLS.error("tcp-units", "the orifice is less than 3 mm or more than 20 m from the flange: metres for mm")
TCP_TURNED = _CELLS.error("tcp-turned", "the jet points back at the flange: the TCP is turned by 180 degrees")
JET_HITS_TOOL = _CELLS.warning("jet-hits-tool", "a body of the tool lies in front of its own orifice")
FIXTURE_UNITS = _CELLS.warning("fixture-units", "a fixture is smaller than 3 mm or larger than 20 m")
BOARD_UPSIDE_DOWN = _CELLS.error("board-upside-down", "the board's top faces down")
BOARD_OUT_OF_REACH = _CELLS.error(
    "board-out-of-reach", "the nearest corner is farther away than all lengths of robot and tool together"
)
FIXTURE_IN_BASE = _CELLS.error("fixture-in-base", "at a check: a fixture reaches more than 20 mm into the robot's base")
FIXTURE_IN_BOARD = _CELLS.warning(
    "fixture-in-board", "a fixture reaches into the box around the board and its components"
)
BOARD_NOT_HELD = _CELLS.info("board-not-held", "no fixture stands close under the board or beside it")

# Checking a program in a cell.
OUT_OF_REACH = _CHECKING.error(
    "out-of-reach", "no configuration reaches some points; by which shift or tilt they would be reached"
)
JOINT_LIMIT = _CHECKING.error(
    "joint-limit", "some points are reached only beyond a joint's limit; which joint, by how much"
)
COLLISION = _CHECKING.error("collision", "two bodies collide in every configuration that was tried")
CONFIGURATION_JUMP = _CHECKING.error("configuration-jump", "a stroke cannot be sprayed in one configuration")
TRANSFER_BLOCKED = _CHECKING.error(
    "transfer-blocked", "a change of configuration or tool is needed, and every way that was tried collides"
)
JUMP = _CHECKING.error("jump", "no joint position continues from the one before it")
CELL_REMEDY = _CHECKING.warning(
    "cell-remedy",
    "what would help, and the keys of the cell to write: a classical mistake undone, wider limits, else the least of "
    "another place of the board, a shorter or longer tool, and a fixture that stands elsewhere",
)
SPEED_NOT_HELD = _CHECKING.warning(
    "speed-not-held",
    "the robot is slower than programmed; where most, which joint, whether its speed or its acceleration. A note where "
    "the nozzle only turns on the spot",
    also="info",
)
NEAR_SINGULAR = _CHECKING.warning("near-singular", "the inverse condition is below 0.02 while spraying")
JET_TILTED = _CHECKING.warning("jet-tilted", "the jet deviates from the programmed direction")
HOME_BLOCKED = _CHECKING.error("home-blocked", "every way from home to the beginning, or back, that was tried collides")
TOOL_CHANGE_ABOVE_BOARD = _CHECKING.warning(
    "tool-change-above-board", "the tool is changed where the orifice is above the board"
)
BOARD_NOT_CHECKED = _CHECKING.warning(
    "board-not-checked", "the board was not found: collisions with it were not checked"
)
BOARD_PLACE_UNKNOWN = _CHECKING.error(
    "board-place-unknown",
    "at an export: the cell holds the board by a corner or its centre, and the board was not found",
)

# Robot programs.
NO_TOOL = _PROGRAMS.error(
    "no-tool", "the program uses a tool that the cell does not have, or moves before it names a nozzle"
)
NO_VALVE = _PROGRAMS.error("no-valve", "a nozzle has no valve in this cell: nothing would be sprayed")
ANALOG_OUT_OF_RANGE = _PROGRAMS.error(
    "analog-out-of-range",
    "a value is more than its analog channel can carry, or an `until` more than its input can show",
)
NO_CHANNEL = _PROGRAMS.warning("no-channel", "a word of the recipe has no channel; it is a comment")
NO_SENSOR = _PROGRAMS.warning(
    "no-sensor", "the cell or the language cannot read the quantity of an `until`; the loop is done as often as allowed"
)
WITHOUT_JOINTS = _PROGRAMS.warning(
    "without-joints", "the program has no joint values: the arm keeps the configuration that it stands in"
)
NO_PLACEMENT = _PROGRAMS.warning(
    "no-placement", "the cell does not state where the board lies after it was turned over"
)
VALVE_PULSE_LENGTHENED = _PROGRAMS.warning(
    "valve-pulse-lengthened", "a pulse is shorter than the valve can follow; the jet ends late"
)
VALVE_STAYS_OPEN = _PROGRAMS.warning("valve-stays-open", "the valve cannot shut between two strokes and stays open")
SLOWER_ON_CONTROLLER = _PROGRAMS.warning(
    "slower-on-controller",
    "the controller's model takes more than 1.10 times the planned time: liquid and dose grow with it",
)
TOO_MANY_POINTS = _PROGRAMS.warning(
    "too-many-points", "a file of the program is longer than its controller is known to take"
)
SHORT_MOVES = _PROGRAMS.info(
    "short-moves",
    "moves take less than 20 ms at their commanded speed while a jet is on; info if all are at corners, else warning",
    also="warning",
)
STOPS_FOR_OUTPUT = _PROGRAMS.warning("stops-for-output", "the controller stops for every output")
WAITS_FOR_VALVE = _PROGRAMS.info("waits-for-valve", "the robot waits because a signal cannot leave earlier")

# Cleaning analysis.
LIQUID_UNKNOWN = _CLEANING.warning(
    "liquid-unknown", "the parameter set does not have the solution; another liquid was assumed"
)
LOOP_ONCE = _CLEANING.info(
    "loop-once", "a loop that a sensor ends is counted once; the verdicts state how often it must be done"
)
BOARD_DIFFERS = _CLEANING.warning("board-differs", "the board is another version than the program was planned for")
RECIPE_DIFFERS = _CLEANING.warning("recipe-differs", "the recipe is another version than the program was planned with")

# Parts: whether a mesh is sound, and what a plan over its faces cannot reach.
PART_PATCHES = _SURFACES.warning("part-patches", "patches without an area were left out")
PART_NORMALS = _SURFACES.warning("part-normals", "patches faced inwards and were turned around")
PART_OPEN = _SURFACES.warning("part-open", "the mesh is open; only the side of its normals is sprayed")
PART_EDGES_SHARED = _SURFACES.warning("part-edges-shared", "edges belong to more than two patches; faces end there")
PART_CROSSES_ITSELF = _SURFACES.error("part-crosses-itself", "patches of the mesh go through each other")
CLOUD_SURFACE = _SURFACES.info("cloud-surface", "a surface was laid through a cloud of points")
CLOUD_POINTS_LEFT_OUT = _SURFACES.warning("cloud-points-left-out", "points beside the surface of a cloud were left out")
CLOUD_ROUGH = _SURFACES.warning("cloud-rough", "points lie far off the surface that was laid")
CLOUD_OPEN = _SURFACES.warning("cloud-open", "the surface of a cloud has rims: holes, or the scan's end")
PART_SIZE = _SURFACES.warning("part-size", "the part is so small or large that its unit is doubtful")
PART_IN_FIXTURE = _SURFACES.warning("part-in-fixture", "some of the part lies inside a fixture")
PART_FACE_TINY = _SURFACES.info("part-face-tiny", "faces without an area to speak of get no stripes")
SCAN_HULL = _SURFACES.warning("scan-hull", "the part is the hull of two silhouettes: the largest that has them")
SCAN_RECESS = _SURFACES.warning("scan-recess", "a silhouette is not convex: hidden recesses are filled")
SCAN_OUTLINE = _SURFACES.warning("scan-outline", "the part's outline differs from its picture's")
SCAN_SPECKS = _SURFACES.info("scan-specks", "small spots and holes of a silhouette were left out")
SURFACE_UNSEEN = _SURFACES.info(
    "surface-unseen", "no free pose of the nozzle sees some of a face; the body that hides it is named"
)
SURFACE_REPAIR = _SURFACES.info("surface-repair", "what a round of the automatic repair changed")
SURFACE_SHORT = _SURFACES.warning(
    "surface-short", "some of what can be seen is not held in the cone for the required time"
)
SURFACE_SLICES = _SURFACES.info(
    "surface-slices", "in how many curves a face is sliced, and in how many in other directions"
)
SURFACE_ORDER = _SURFACES.info("surface-order", "stripes, faces, and the travel between them")
SURFACE_CUT = _SURFACES.info("surface-cut", "stripes are interrupted where no pose within the tilt limits is free")

FINDING_RULES: dict[str, FindingRule] = {
    each.id: each for each in tuple(globals().values()) if isinstance(each, FindingRule)
}
"""Every rule by its id, in the order of this file."""


def check_allowed(allowed: Iterable[str]) -> list[str]:
    """Return the rules whose errors do not block, as ``--allow`` names them.

    Raises:
        JobError: a name is no rule's.
    """
    names = list(allowed)
    for name in names:
        if name not in FINDING_RULES:
            nearest = ", ".join(difflib.get_close_matches(name, FINDING_RULES, cutoff=0.0))
            raise JobError(f"--allow {name}: no finding has this rule; the nearest are {nearest}.")
    return names
