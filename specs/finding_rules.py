"""Every finding rule once: its id, its severity, its meaning, and the page of ``docs`` that lists it.

Verdicts of the cleaning model become findings too; their rules are derived from R1 to R14 where they are reported.
"""

import difflib
from collections.abc import Iterable

from specs.errors import JobError
from specs.finding import FindingRule

_BOARDS = "boards.md"
_CELLS = "cells.md"
_CHECKING = "checking.md"
_CLEANING = "cleaning.md"
_PLANNING = "planning.md"
_PROGRAMS = "robot-programs.md"
_RECIPE = "recipe.md"
_SURFACES = "surfaces.md"

# Boards: how a file was read, and whether the board makes sense.
TRI_LEGACY = FindingRule(
    "tri-legacy", "info", "a `.tri` file holds numbers only: mm and the largest object assumed", _BOARDS
)
TRI_DEGENERATE = FindingRule("tri-degenerate", "warning", "patches without an area were left out", _BOARDS)
TRI_ZERO_NORMAL = FindingRule(
    "tri-zero-normal", "warning", "a normal has zero length; that of the winding was taken", _BOARDS
)
TRI_NORMAL = FindingRule("tri-normal", "warning", "a normal is more than 90 degrees away from its winding", _BOARDS)
UNIT_GUESSED = FindingRule(
    "unit-guessed", "warning", "the board's size fits another unit than the format's; that unit was taken", _BOARDS
)
BOARD_TURNED = FindingRule("board-turned", "info", "the board did not lie in the x/y plane and was turned", _BOARDS)
BOARD_NOT_TURNED = FindingRule(
    "board-not-turned", "info", "a glTF file has y up, but its board lies in the x/y plane already", _BOARDS
)
NO_COMPONENTS = FindingRule("no-components", "warning", "the file holds nothing but the board", _BOARDS)
PART_WITHOUT_GEOMETRY = FindingRule(
    "part-without-geometry",
    "warning",
    "parts of a STEP file or of a placement table have no geometry and are missing",
    _BOARDS,
)
BOARD_LAYERS = FindingRule("board-layers", "info", "bodies within the board's thickness were left out", _BOARDS)
COMPONENT_WITHOUT_HEIGHT = FindingRule(
    "component-without-height", "warning", "named parts have no height above the board and were left out", _BOARDS
)
NOT_ON_THE_BOARD = FindingRule(
    "not-on-the-board", "warning", "bodies do not stand on the board and were kept as obstacles", _BOARDS
)
MODELS_JOINED = FindingRule("models-joined", "info", "touching bodies of one name became one component", _BOARDS)
REPEATED_NAME = FindingRule(
    "repeated-name", "warning", "components share a reference designator and were renamed", _BOARDS
)
NO_BODY = FindingRule("no-body", "info", "footprints or placed objects without a body were left out", _BOARDS)
IDF_UNPLACED = FindingRule("idf-unplaced", "info", "an IDF file has components that are not placed yet", _BOARDS)
SMALL_DRILLS = FindingRule("small-drills", "info", "small drilled holes were left out of the outline", _BOARDS)
DOUBTFUL_HEIGHT = FindingRule(
    "doubtful-height",
    "warning",
    "stated heights contradict the packages, or are a layout tool's default",
    _BOARDS,
)
KICAD_VERSION = FindingRule("kicad-version", "warning", "the file is of a KiCad version that is not known", _BOARDS)
EAGLE_VERSION = FindingRule("eagle-version", "warning", "the file is of an Eagle version that is not known", _BOARDS)
OPEN_EDGE = FindingRule("open-edge", "warning", "lines of the board's edge enclose nothing and were left out", _BOARDS)
ASSUMED_HEIGHT = FindingRule(
    "assumed-height", "warning", "components of no known package family were assumed tall", _BOARDS
)
OUTLINE_FROM_PADS = FindingRule(
    "outline-from-pads", "warning", "footprints without a drawing: the box around their pads is their body", _BOARDS
)
BOARD_IN_PIECES = FindingRule("board-in-pieces", "warning", "the bare board consists of several pieces", _BOARDS)
ALL_ON_BOTTOM = FindingRule("all-on-bottom", "warning", "every component lies on the bottom side", _BOARDS)
COMPONENT_OUTSIDE = FindingRule(
    "component-outside", "warning", "a component lies more than 5 mm outside the board's outline", _BOARDS
)
COMPONENT_FLOATING = FindingRule(
    "component-floating", "warning", "a component is more than 5 mm away from the board's surface", _BOARDS
)
COMPONENT_SUNK = FindingRule(
    "component-sunk", "warning", "less than half of a component's surface lies above its side of the board", _BOARDS
)
PARTS_BY_POSITION = FindingRule(
    "parts-by-position", "info", "rows of the parts table were joined by position instead of by name", _BOARDS
)
PARTS_FRAME = FindingRule(
    "parts-frame", "info", "positions of the parts table were turned, mirrored or moved to fit the board", _BOARDS
)
PARTS_POSITION = FindingRule(
    "parts-position", "warning", "positions of the parts table do not fit those of the components", _BOARDS
)
PARTS_NOT_ON_BOARD = FindingRule(
    "parts-not-on-board", "warning", "rows of the parts table have no component on the board", _BOARDS
)
PARTS_NOT_IN_TABLE = FindingRule("parts-not-in-table", "warning", "components have no row in the parts table", _BOARDS)
PARTS_CONTRADICT = FindingRule(
    "parts-contradict", "warning", "entries of the parts table contradict the board file", _BOARDS
)

# Recipes: what is allowed but probably not meant.
UNUSED_FUNCTION = FindingRule("unused-function", "warning", "no step uses this function", _RECIPE)
UNUSED_NOZZLE = FindingRule("unused-nozzle", "warning", "no step uses this nozzle", _RECIPE)
UNUSED_TEMPLATE = FindingRule("unused-template", "warning", "no step uses this template", _RECIPE)
CLASS_OUT_OF_REACH = FindingRule("class-out-of-reach", "warning", "a class before it takes every component", _RECIPE)
NO_CLASS_FOR_THE_REST = FindingRule("no-class-for-the-rest", "warning", "no class takes what the others leave", _RECIPE)
NEAR_WITHIN_MERGE_GAP = FindingRule(
    "near-within-merge-gap",
    "warning",
    "components so close are followed as one outline, so `near` seldom holds",
    _RECIPE,
)
RING_CONTRADICTS_HALF_ANGLE = FindingRule(
    "ring-contradicts-half-angle",
    "warning",
    "the measured wave front and `half_angle_deg` differ by more than 8 degrees",
    _RECIPE,
)

RINSE_BEFORE_CLEAN = FindingRule(
    "rinse-before-clean", "warning", "a step rinses before the first step that washes the board", _RECIPE
)

# Planning.
CLASS_EMPTY = FindingRule("class-empty", "info", "a class has no member on this board", _PLANNING)
MASK_EMPTY = FindingRule("mask-empty", "warning", "a mask's pattern matches nothing", _PLANNING)
MASK_CONFLICT = FindingRule("mask-conflict", "error", "a component is to be avoided and to be cleaned", _PLANNING)
NOT_SERVED = FindingRule(
    "not-served",
    "error",
    "a component that must be cleaned is on a side that no step sprays, or no pass goes around it",
    _PLANNING,
)
LEAST_TIME_MISSED = FindingRule(
    "least-time-missed",
    "warning",
    "a step sprays for less than its least time, and no repeat of its last path helps",
    _PLANNING,
)
SIDE_NOT_SPRAYED = FindingRule(
    "side-not-sprayed",
    "warning",
    "components of a side are not sprayed: no step has this side, or paths around components alone leave them "
    "out. An error where only the other side is sprayed, which has no components",
    _PLANNING,
    also="error",
)
WAVEFRONT_BEHIND_NOZZLE = FindingRule(
    "wavefront-behind-nozzle", "warning", "the tilt is smaller than the half angle", _PLANNING
)
NO_PATH_INSIDE = FindingRule(
    "no-path-inside", "warning", "a path that far inside the outline does not exist", _PLANNING
)
NOT_CIRCLED = FindingRule(
    "not-circled",
    "warning",
    "a path inside the outline of a group leaves some of its components outside",
    _PLANNING,
)
NARROW_CORRIDOR = FindingRule("narrow-corridor", "info", "neighbours stand closer than the cone is wide", _PLANNING)
SPRAY_BESIDE_BOARD = FindingRule(
    "spray-beside-board", "info", "less than half of the spray of a template lands on the board", _PLANNING
)
MARGIN_REDUCED = FindingRule("margin-reduced", "info", "the margin leaves nothing of a narrow board", _PLANNING)
PITCH_TOO_WIDE = FindingRule("pitch-too-wide", "warning", "a stated pitch leaves strips uncovered", _PLANNING)
RAISED_OVER_BODY = FindingRule("raised-over-body", "warning", "a stroke was raised to keep its clearance", _PLANNING)
CUT_BY_MASK = FindingRule(
    "cut-by-mask",
    "info",
    "strokes were cut to keep the wave front off what is avoided; a warning where whole strokes or a tenth are lost",
    _PLANNING,
    also="warning",
)
LEAD_IN_BLOCKED = FindingRule("lead-in-blocked", "info", "no room for a run-up", _PLANNING)
ORDER_GAIN = FindingRule("order-gain", "info", "what the order of strokes saved", _PLANNING)
SPEED_BELOW_PROGRAMMED = FindingRule(
    "speed-below-programmed",
    "warning",
    "the programmed speed is not reached while spraying; a note where that is so on less than half of the length",
    _PLANNING,
    also="info",
)

ROBOT_LIMITS = FindingRule(
    "robot-limits",
    "warning",
    "with a cell: the robot cannot carry out the program, or takes more than 1.05 times the planned time. A note "
    "otherwise: what its limits cost against those of the recipe alone, by kind of motion",
    _PLANNING,
    also="info",
)

# Cells: what is probably not meant.
TCP_UNITS = FindingRule(
    "tcp-units", "error", "the orifice is less than 3 mm or more than 20 m from the flange: metres for mm", _CELLS
)
TCP_TURNED = FindingRule(
    "tcp-turned", "error", "the jet points back at the flange: the TCP is turned by 180 degrees", _CELLS
)
JET_HITS_TOOL = FindingRule("jet-hits-tool", "warning", "a body of the tool lies in front of its own orifice", _CELLS)
FIXTURE_UNITS = FindingRule("fixture-units", "warning", "a fixture is smaller than 3 mm or larger than 20 m", _CELLS)
BOARD_UPSIDE_DOWN = FindingRule("board-upside-down", "error", "the board's top faces down", _CELLS)
BOARD_OUT_OF_REACH = FindingRule(
    "board-out-of-reach",
    "error",
    "the nearest corner is farther away than all lengths of robot and tool together",
    _CELLS,
)
FIXTURE_IN_BASE = FindingRule(
    "fixture-in-base", "error", "at a check: a fixture reaches more than 20 mm into the robot's base", _CELLS
)
FIXTURE_IN_BOARD = FindingRule(
    "fixture-in-board", "warning", "a fixture reaches into the box around the board and its components", _CELLS
)
BOARD_NOT_HELD = FindingRule("board-not-held", "info", "no fixture stands close under the board or beside it", _CELLS)

# Checking a program in a cell.
OUT_OF_REACH = FindingRule(
    "out-of-reach",
    "error",
    "no configuration reaches some points; by which shift or tilt they would be reached",
    _CHECKING,
)
JOINT_LIMIT = FindingRule(
    "joint-limit",
    "error",
    "some points are reached only beyond a joint's limit; which joint, by how much",
    _CHECKING,
)
COLLISION = FindingRule("collision", "error", "two bodies collide in every configuration that was tried", _CHECKING)
CONFIGURATION_JUMP = FindingRule(
    "configuration-jump", "error", "a stroke cannot be sprayed in one configuration", _CHECKING
)
TRANSFER_BLOCKED = FindingRule(
    "transfer-blocked",
    "error",
    "a change of configuration or tool is needed, and every way that was tried collides",
    _CHECKING,
)
JUMP = FindingRule("jump", "error", "no joint position continues from the one before it", _CHECKING)
CELL_REMEDY = FindingRule(
    "cell-remedy",
    "warning",
    "what would help, and the keys of the cell to write: a classical mistake undone, wider limits, else the least of "
    "another place of the board, a shorter or longer tool, and a fixture that stands elsewhere",
    _CHECKING,
)
SPEED_NOT_HELD = FindingRule(
    "speed-not-held",
    "warning",
    "the robot is slower than programmed; where most, which joint, whether its speed or its acceleration. A note where "
    "the nozzle only turns on the spot",
    _CHECKING,
    also="info",
)
NEAR_SINGULAR = FindingRule("near-singular", "warning", "the inverse condition is below 0.02 while spraying", _CHECKING)
JET_TILTED = FindingRule("jet-tilted", "warning", "the jet deviates from the programmed direction", _CHECKING)
HOME_BLOCKED = FindingRule(
    "home-blocked", "error", "every way from home to the beginning, or back, that was tried collides", _CHECKING
)
TOOL_CHANGE_ABOVE_BOARD = FindingRule(
    "tool-change-above-board", "warning", "the tool is changed where the orifice is above the board", _CHECKING
)
BOARD_NOT_CHECKED = FindingRule(
    "board-not-checked", "warning", "the board was not found: collisions with it were not checked", _CHECKING
)
BOARD_PLACE_UNKNOWN = FindingRule(
    "board-place-unknown",
    "error",
    "at an export: the cell holds the board by a corner or its centre, and the board was not found",
    _CHECKING,
)

# Robot programs.
NO_TOOL = FindingRule(
    "no-tool",
    "error",
    "the program uses a tool that the cell does not have, or moves before it names a nozzle",
    _PROGRAMS,
)
NO_VALVE = FindingRule("no-valve", "error", "a nozzle has no valve in this cell: nothing would be sprayed", _PROGRAMS)
ANALOG_OUT_OF_RANGE = FindingRule(
    "analog-out-of-range",
    "error",
    "a value is more than its analog channel can carry, or an `until` more than its input can show",
    _PROGRAMS,
)
NO_CHANNEL = FindingRule("no-channel", "warning", "a word of the recipe has no channel; it is a comment", _PROGRAMS)
NO_SENSOR = FindingRule(
    "no-sensor",
    "warning",
    "the cell or the language cannot read the quantity of an `until`; the loop is done as often as allowed",
    _PROGRAMS,
)
WITHOUT_JOINTS = FindingRule(
    "without-joints",
    "warning",
    "the program has no joint values: the arm keeps the configuration that it stands in",
    _PROGRAMS,
)
NO_PLACEMENT = FindingRule(
    "no-placement", "warning", "the cell does not state where the board lies after it was turned over", _PROGRAMS
)
VALVE_PULSE_LENGTHENED = FindingRule(
    "valve-pulse-lengthened", "warning", "a pulse is shorter than the valve can follow; the jet ends late", _PROGRAMS
)
VALVE_STAYS_OPEN = FindingRule(
    "valve-stays-open", "warning", "the valve cannot shut between two strokes and stays open", _PROGRAMS
)
SLOWER_ON_CONTROLLER = FindingRule(
    "slower-on-controller",
    "warning",
    "the controller's model takes more than 1.10 times the planned time: liquid and dose grow with it",
    _PROGRAMS,
)
TOO_MANY_POINTS = FindingRule(
    "too-many-points", "warning", "a file of the program is longer than its controller is known to take", _PROGRAMS
)
SHORT_MOVES = FindingRule(
    "short-moves",
    "info",
    "moves take less than 20 ms at their commanded speed while a jet is on; info if all are at corners, else warning",
    _PROGRAMS,
    also="warning",
)
STOPS_FOR_OUTPUT = FindingRule("stops-for-output", "warning", "the controller stops for every output", _PROGRAMS)
WAITS_FOR_VALVE = FindingRule(
    "waits-for-valve", "info", "the robot waits because a signal cannot leave earlier", _PROGRAMS
)

# Cleaning analysis.
LIQUID_UNKNOWN = FindingRule(
    "liquid-unknown", "warning", "the parameter set does not have the solution; another liquid was assumed", _CLEANING
)
LOOP_ONCE = FindingRule(
    "loop-once",
    "info",
    "a loop that a sensor ends is counted once; the verdicts state how often it must be done",
    _CLEANING,
)
BOARD_DIFFERS = FindingRule(
    "board-differs", "warning", "the board is another version than the program was planned for", _CLEANING
)
RECIPE_DIFFERS = FindingRule(
    "recipe-differs", "warning", "the recipe is another version than the program was planned with", _CLEANING
)

# Parts: whether a mesh is sound, and what a plan over its faces cannot reach.
PART_PATCHES = FindingRule("part-patches", "warning", "patches without an area were left out", _SURFACES)
PART_NORMALS = FindingRule("part-normals", "warning", "patches faced inwards and were turned around", _SURFACES)
PART_OPEN = FindingRule("part-open", "warning", "the mesh is open; only the side of its normals is sprayed", _SURFACES)
PART_EDGES_SHARED = FindingRule(
    "part-edges-shared", "warning", "edges belong to more than two patches; faces end there", _SURFACES
)
PART_CROSSES_ITSELF = FindingRule(
    "part-crosses-itself", "error", "patches of the mesh go through each other", _SURFACES
)
CLOUD_SURFACE = FindingRule("cloud-surface", "info", "a surface was laid through a cloud of points", _SURFACES)
CLOUD_POINTS_LEFT_OUT = FindingRule(
    "cloud-points-left-out", "warning", "points beside the surface of a cloud were left out", _SURFACES
)
CLOUD_ROUGH = FindingRule("cloud-rough", "warning", "points lie far off the surface that was laid", _SURFACES)
CLOUD_OPEN = FindingRule(
    "cloud-open", "warning", "the surface of a cloud has rims: holes, or the scan's end", _SURFACES
)
PART_SIZE = FindingRule("part-size", "warning", "the part is so small or large that its unit is doubtful", _SURFACES)
PART_IN_FIXTURE = FindingRule("part-in-fixture", "warning", "some of the part lies inside a fixture", _SURFACES)
PART_FACE_TINY = FindingRule("part-face-tiny", "info", "faces without an area to speak of get no stripes", _SURFACES)
SCAN_HULL = FindingRule(
    "scan-hull", "warning", "the part is the hull of two silhouettes: the largest that has them", _SURFACES
)
SCAN_RECESS = FindingRule("scan-recess", "warning", "a silhouette is not convex: hidden recesses are filled", _SURFACES)
SCAN_OUTLINE = FindingRule("scan-outline", "warning", "the part's outline differs from its picture's", _SURFACES)
SCAN_SPECKS = FindingRule("scan-specks", "info", "small spots and holes of a silhouette were left out", _SURFACES)
SURFACE_UNSEEN = FindingRule(
    "surface-unseen",
    "info",
    "no free pose of the nozzle sees some of a face; the body that hides it is named",
    _SURFACES,
)
SURFACE_REPAIR = FindingRule("surface-repair", "info", "what a round of the automatic repair changed", _SURFACES)
SURFACE_SHORT = FindingRule(
    "surface-short", "warning", "some of what can be seen is not held in the cone for the required time", _SURFACES
)
SURFACE_SLICES = FindingRule(
    "surface-slices", "info", "in how many curves a face is sliced, and in how many in other directions", _SURFACES
)
SURFACE_ORDER = FindingRule("surface-order", "info", "stripes, faces, and the travel between them", _SURFACES)
SURFACE_CUT = FindingRule(
    "surface-cut", "info", "stripes are interrupted where no pose within the tilt limits is free", _SURFACES
)

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
