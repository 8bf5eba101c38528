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

    def error(self, meaning: str, also: Severity | None = None) -> FindingRule:
        return FindingRule("", "error", meaning, self.name, also)

    def warning(self, meaning: str, also: Severity | None = None) -> FindingRule:
        return FindingRule("", "warning", meaning, self.name, also)

    def info(self, meaning: str, also: Severity | None = None) -> FindingRule:
        return FindingRule("", "info", meaning, self.name, also)


_BOARDS = _Page("boards.md")
_CELLS = _Page("cells.md")
_CHECKING = _Page("checking.md")
_CLEANING = _Page("cleaning.md")
_FILM = _Page("film.md")
_PLANNING = _Page("planning.md")
_PROGRAMS = _Page("robot-programs.md")
_RECIPE = _Page("recipe.md")
_SURFACES = _Page("surfaces.md")

# Boards: how a file was read, and whether the board makes sense.
TRI_LEGACY = _BOARDS.info("a `.tri` file holds numbers only: mm and the largest object assumed")
TRI_DEGENERATE = _BOARDS.warning("patches without an area were left out")
TRI_ZERO_NORMAL = _BOARDS.warning("a normal has zero length; that of the winding was taken")
TRI_NORMAL = _BOARDS.warning("a normal is more than 90 degrees away from its winding")
UNIT_GUESSED = _BOARDS.warning("the board's size fits another unit than the format's; that unit was taken")
BOARD_TURNED = _BOARDS.info("the board did not lie in the x/y plane and was turned")
BOARD_NOT_TURNED = _BOARDS.info("a glTF file has y up, but its board lies in the x/y plane already")
NO_COMPONENTS = _BOARDS.warning("the file holds nothing but the board")
PART_WITHOUT_GEOMETRY = _BOARDS.warning("parts of a STEP file or of a placement table have no geometry and are missing")
BOARD_LAYERS = _BOARDS.info("bodies within the board's thickness were left out")
COMPONENT_WITHOUT_HEIGHT = _BOARDS.warning("named parts have no height above the board and were left out")
NOT_ON_THE_BOARD = _BOARDS.warning("bodies do not stand on the board and were kept as obstacles")
NESTED_BOARDS = _BOARDS.warning("an assembly holds several boards; all but one are parts of it")
MODELS_JOINED = _BOARDS.info("touching bodies of one name became one component")
REPEATED_NAME = _BOARDS.warning("components share a reference designator and were renamed")
NO_BODY = _BOARDS.info("footprints or placed objects without a body were left out")
IDF_UNPLACED = _BOARDS.info("an IDF file has components that are not placed yet")
SMALL_DRILLS = _BOARDS.info("small drilled holes were left out of the outline")
DOUBTFUL_HEIGHT = _BOARDS.warning("stated heights contradict the packages, or are a layout tool's default")
KICAD_VERSION = _BOARDS.warning("the file is of a KiCad version that is not known")
EAGLE_VERSION = _BOARDS.warning("the file is of an Eagle version that is not known")
EDGE_GAP = _BOARDS.warning("gaps in the board's edge, no wider than its pen or a mil, were closed")
EDGE_LAYERS = _BOARDS.warning("further layers that are named like the board's edge were left out")
LAYERS_MISSING = _BOARDS.warning("a Gerber job file lists outer layers that are not there")
OPEN_EDGE = _BOARDS.warning("lines of the board's edge enclose nothing and were left out")
ASSUMED_HEIGHT = _BOARDS.warning("components of no known package family were assumed tall")
OUTLINE_FROM_PADS = _BOARDS.warning("footprints without a drawing: the box around their pads is their body")
BOARD_IN_PIECES = _BOARDS.warning("the bare board consists of several pieces")
ALL_ON_BOTTOM = _BOARDS.warning("every component lies on the bottom side")
COMPONENT_OUTSIDE = _BOARDS.warning(
    "components lie more than 5 mm outside the board's outline; an error where most do", "error"
)
COMPONENT_OFF_PADS = _BOARDS.warning("bodies of components lie beside the pads that they are soldered to")
COMPONENT_FLOATING = _BOARDS.warning("components are more than 5 mm away from the board's surface")
COMPONENT_SUNK = _BOARDS.warning("less than half of the surface of components lies above their side of the board")
PARTS_BY_POSITION = _BOARDS.info("rows of the parts table were joined by position instead of by name")
PARTS_FRAME = _BOARDS.info("positions of the parts table were turned, mirrored or moved to fit the board")
PARTS_POSITION = _BOARDS.warning("positions of the parts table do not fit those of the components")
PARTS_FOUND = _BOARDS.info("parts tables or netlists were found in the folder or archive of the board and are joined")
PARTS_COLUMNS = _BOARDS.info("a columns file is used; a warning where no table has a title that it states", "warning")
ORDER_BOARDS = _BOARDS.error(
    "an order holds several boards, or a model of another, and nothing states which one is meant"
)
MODEL_FOUND = _BOARDS.info("components have the bodies of a 3-D model beside the file of their board")
MODEL_WITHOUT_BODY = _BOARDS.info("components have no body in the 3-D model beside the file of their board")
MODEL_OBSTACLES = _BOARDS.warning("bodies of a 3-D model are of no component of the board, and are kept as obstacles")
PANEL_FOUND = _BOARDS.info("a file holds several boards, which are taken apart as a panel")
PANEL_BOARDS = _BOARDS.error(
    "whether a file is one board or a panel is open; a warning where one board is likely", "warning"
)
PARTS_TURN = _BOARDS.info("how turns in a parts table are counted by the copper, and whose half turn stays undecided")
PARTS_UNIT = _BOARDS.error("the unit of a parts table's places is not stated, and two readings fit the board")
PARTS_NOT_FITTED = _BOARDS.info("a parts table, or the board's file beside a model, leaves components out: not fitted")
PARTS_TABLES = _BOARDS.error(
    "tables place the same components otherwise, and nothing states which is meant; a warning if the copper shows it",
    "warning",
)
PARTS_TITLES = _BOARDS.error(
    "a text seems to be a parts table whose titles are not known; a warning where another table places components",
    "warning",
)
PARTS_NOT_ON_BOARD = _BOARDS.warning(
    "rows of the parts table have no component on the board; an error where none has", "error"
)
PARTS_NOT_IN_TABLE = _BOARDS.warning("components have no row in the parts table")
PARTS_CONTRADICT = _BOARDS.warning(
    "entries of the parts table, or a 3-D model, contradict the board file; one finding for each kind of statement"
)

# Recipes: what is allowed but probably not meant.
UNUSED_FUNCTION = _RECIPE.warning("no step uses this function")
UNUSED_NOZZLE = _RECIPE.warning("no step uses this nozzle")
UNUSED_TEMPLATE = _RECIPE.warning("no step uses this template")
CLASS_OUT_OF_REACH = _RECIPE.warning("a class before it takes every component")
NO_CLASS_FOR_THE_REST = _RECIPE.warning("no class takes what the others leave")
NEAR_WITHIN_MERGE_GAP = _RECIPE.warning("components so close are followed as one outline, so `near` seldom holds")
RING_CONTRADICTS_HALF_ANGLE = _RECIPE.warning(
    "the measured wave front and `half_angle_deg` differ by more than 8 degrees"
)

RINSE_BEFORE_CLEAN = _RECIPE.warning("a step rinses before the first step that washes the board")

# Planning.
CLASS_EMPTY = _PLANNING.info("a class has no member on this board")
MASK_EMPTY = _PLANNING.warning("a mask's pattern matches nothing")
MASK_CONFLICT = _PLANNING.error("a component is to be avoided and to be cleaned")
NOT_SERVED = _PLANNING.error(
    "a component that must be cleaned is on a side that no step sprays, or no pass goes around it"
)
LEAST_TIME_MISSED = _PLANNING.warning(
    "a step sprays for less than its least time, and no repeat of its last path helps"
)
SIDE_NOT_SPRAYED = _PLANNING.warning(
    "components of a side are not sprayed: no step has this side, or paths around components alone leave them "
    "out. An error where only the other side is sprayed, which has no components",
    also="error",
)
WAVEFRONT_BEHIND_NOZZLE = _PLANNING.warning("the tilt is smaller than the half angle")
NO_PATH_INSIDE = _PLANNING.warning("a path that far inside the outline does not exist")
NOT_CIRCLED = _PLANNING.warning("a path inside the outline of a group leaves some of its components outside")
NARROW_CORRIDOR = _PLANNING.info("neighbours stand closer than the cone is wide")
SPRAY_BESIDE_BOARD = _PLANNING.info("less than half of the spray of a template lands on the board")
MARGIN_REDUCED = _PLANNING.info("the margin leaves nothing of a narrow board")
PITCH_TOO_WIDE = _PLANNING.warning("a stated pitch leaves strips uncovered")
RAISED_OVER_BODY = _PLANNING.warning("a stroke was raised to keep its clearance")
CUT_BY_MASK = _PLANNING.info(
    "strokes were cut to keep the wave front off what is avoided; a warning where whole strokes or a tenth are lost",
    also="warning",
)
LEAD_IN_BLOCKED = _PLANNING.info("no room for a run-up")
ORDER_GAIN = _PLANNING.info("what the order of strokes saved")
SPEED_BELOW_PROGRAMMED = _PLANNING.warning(
    "the programmed speed is not reached while spraying; a note where that is so on less than half of the length",
    also="info",
)

ROBOT_LIMITS = _PLANNING.warning(
    "with a cell: the robot cannot carry out the program, or takes more than 1.05 times the planned time. A note "
    "otherwise: what its limits cost against those of the recipe alone, by kind of motion",
    also="info",
)

# Cells: what is probably not meant.
TCP_UNITS = _CELLS.error("the orifice is less than 3 mm or more than 20 m from the flange: metres for mm")
TCP_TURNED = _CELLS.error("the jet points back at the flange: the TCP is turned by 180 degrees")
JET_HITS_TOOL = _CELLS.warning("a body of the tool lies in front of its own orifice")
FIXTURE_UNITS = _CELLS.warning("a fixture is smaller than 3 mm or larger than 20 m")
BOARD_UPSIDE_DOWN = _CELLS.error("the board's top faces down")
BOARD_OUT_OF_REACH = _CELLS.error("the nearest corner is farther away than all lengths of robot and tool together")
FIXTURE_IN_BASE = _CELLS.error("at a check: a fixture reaches more than 20 mm into the robot's base")
FIXTURE_IN_BOARD = _CELLS.warning("a fixture reaches into the box around the board and its components")
BOARD_NOT_HELD = _CELLS.info("no fixture stands close under the board or beside it")

# Checking a program in a cell.
OUT_OF_REACH = _CHECKING.error("no configuration reaches some points; by which shift or tilt they would be reached")
JOINT_LIMIT = _CHECKING.error("some points are reached only beyond a joint's limit; which joint, by how much")
COLLISION = _CHECKING.error("two bodies collide in every configuration that was tried")
CONFIGURATION_JUMP = _CHECKING.error("a stroke cannot be sprayed in one configuration")
TRANSFER_BLOCKED = _CHECKING.error("a change of configuration or tool is needed, and every way that was tried collides")
JUMP = _CHECKING.error("no joint position continues from the one before it")
CELL_REMEDY = _CHECKING.warning(
    "what would help, and the keys of the cell to write: a classical mistake undone, wider limits, else the least of "
    "another place of the board, a shorter or longer tool, and a fixture that stands elsewhere"
)
SPEED_NOT_HELD = _CHECKING.warning(
    "the robot is slower than programmed; where most, which joint, whether its speed or its acceleration. A note where "
    "the nozzle only turns on the spot",
    also="info",
)
NEAR_SINGULAR = _CHECKING.warning("the inverse condition is below 0.02 while spraying")
JET_TILTED = _CHECKING.warning("the jet deviates from the programmed direction")
HOME_BLOCKED = _CHECKING.error("every way from home to the beginning, or back, that was tried collides")
TOOL_CHANGE_ABOVE_BOARD = _CHECKING.warning("the tool is changed where the orifice is above the board")
BOARD_NOT_CHECKED = _CHECKING.warning("the board was not found: collisions with it were not checked")
BOARD_PLACE_UNKNOWN = _CHECKING.error(
    "at an export: the cell holds the board by a corner or its centre, and the board was not found"
)

# Robot programs.
NO_TOOL = _PROGRAMS.error("the program uses a tool that the cell does not have, or moves before it names a nozzle")
NO_VALVE = _PROGRAMS.error("a nozzle has no valve in this cell: nothing would be sprayed")
ANALOG_OUT_OF_RANGE = _PROGRAMS.error(
    "a value is more than its analog channel can carry, or an `until` more than its input can show"
)
NO_CHANNEL = _PROGRAMS.warning("a word of the recipe has no channel; it is a comment")
NO_SENSOR = _PROGRAMS.warning(
    "the cell or the language cannot read the quantity of an `until`; the loop is done as often as allowed"
)
WITHOUT_JOINTS = _PROGRAMS.warning("the program has no joint values: the arm keeps the configuration that it stands in")
NO_PLACEMENT = _PROGRAMS.warning("the cell does not state where the board lies after it was turned over")
VALVE_PULSE_LENGTHENED = _PROGRAMS.warning("a pulse is shorter than the valve can follow; the jet ends late")
VALVE_STAYS_OPEN = _PROGRAMS.warning("the valve cannot shut between two strokes and stays open")
SLOWER_ON_CONTROLLER = _PROGRAMS.warning(
    "the controller's model takes more than 1.10 times the planned time: liquid and dose grow with it"
)
DOSE_DIFFERS = _PROGRAMS.warning(
    "strokes whose jet, by the controller's model, is on for less than 0.97 or more than 1.03 times the planned time"
)
VERDICT_DIFFERS = _PROGRAMS.warning(
    "components or faces are predicted to come out otherwise as the controller drives the program than as it was "
    "planned; info if they only come out better",
    also="info",
)
TOO_MANY_POINTS = _PROGRAMS.warning("a file of the program is longer than its controller is known to take")
SHORT_MOVES = _PROGRAMS.info(
    "moves take less than 20 ms at their commanded speed while a jet is on; info if all are at corners, else warning",
    also="warning",
)
STOPS_FOR_OUTPUT = _PROGRAMS.warning("the controller stops for every output")
WAITS_FOR_VALVE = _PROGRAMS.info("the robot waits because a signal cannot leave earlier")

# Cleaning analysis.
LIQUID_UNKNOWN = _CLEANING.warning("the parameter set does not have the solution; another liquid was assumed")
LOOP_ONCE = _CLEANING.info("a loop that a sensor ends is counted once; the verdicts state how often it must be done")
BOARD_DIFFERS = _CLEANING.warning("the board is another version than the program was planned for")
RECIPE_DIFFERS = _CLEANING.warning("the recipe is another version than the program was planned with")

# Parts: whether a mesh is sound, and what a plan over its faces cannot reach.
PART_PATCHES = _SURFACES.warning("patches without an area, or that are there twice, were left out")
PART_NORMALS = _SURFACES.warning("patches faced inwards and were turned around")
PART_OPEN = _SURFACES.warning("the mesh is open; only the side of its normals is sprayed")
PART_EDGES_SHARED = _SURFACES.warning("edges belong to more than two patches; faces end there")
PART_CROSSES_ITSELF = _SURFACES.error("patches of the mesh go through each other")
CLOUD_SURFACE = _SURFACES.info("a surface was laid through a cloud of points")
CLOUD_DECIMAL_COMMAS = _SURFACES.info("the numbers of a cloud have commas for decimal points")
CLOUD_POINTS_LEFT_OUT = _SURFACES.warning("points beside the surface of a cloud, or that are no numbers, were left out")
CLOUD_ROUGH = _SURFACES.warning("points lie far off the surface that was laid")
CLOUD_OPEN = _SURFACES.warning("the surface of a cloud has rims: holes, or the scan's end")
PART_SIZE = _SURFACES.warning("the part is so small or large that its unit is doubtful")
PART_HOLES_FILLED = _SURFACES.info("holes of a mesh, up to the width that is stated, were filled")
PART_HOLES_NONE = _SURFACES.warning("no hole of a mesh is as narrow as those that are to be filled")
PART_IGNORES_NOTHING = _SURFACES.warning("a name or direction under faces: ignore is that of no face")
PART_IN_FIXTURE = _SURFACES.warning("some of the part lies inside a fixture")
PART_FACE_TINY = _SURFACES.info("faces without an area to speak of get no stripes")
SCAN_HULL = _SURFACES.warning("the part is the hull of two silhouettes: the largest that has them")
SCAN_RECESS = _SURFACES.warning("a silhouette is not convex: hidden recesses are filled")
SCAN_OUTLINE = _SURFACES.warning("the part's outline differs from its picture's")
SCAN_SHADOW = _SURFACES.warning("a grey between part and ground was left out as a shadow")
SCAN_SPECKS = _SURFACES.info("small spots and holes of a silhouette were left out")
SURFACE_UNSEEN = _SURFACES.info("no free pose of the nozzle sees some of a face; the body that hides it is named")
SURFACE_REPAIR = _SURFACES.info("what a round of the automatic repair changed")
SURFACE_SHORT = _SURFACES.warning("some of what can be seen is not held in the cone for the required time")
SURFACE_SLICES = _SURFACES.info("in how many curves a face is sliced, and in how many in other directions")
SURFACE_ORDER = _SURFACES.info("stripes, faces, and the travel between them")
SURFACE_CUT = _SURFACES.info("stripes are interrupted where no pose within the tilt limits is free")
FILM_LEVELLED = _FILM.info("how even the film of a step is after levelling, and how even at one speed")
FILM_UNEVEN = _FILM.warning("a film is thinner or thicker somewhere than its tolerance allows")


def _name_rules() -> dict[str, FindingRule]:
    """Give each rule its name here as its id, in kebab-case."""
    found = {name.lower().replace("_", "-"): each for name, each in globals().items() if isinstance(each, FindingRule)}
    for id_, rule in found.items():
        object.__setattr__(rule, "id", id_)
    return found


FINDING_RULES = _name_rules()
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
