"""Path classes as specs, the six of Sandia 1993 for boards, its stripes over parts, and slices of free form.

Planners of paths over boards are ``rulesengine/paths/<same word>.py``; over parts it is ``rulesengine/surface``.

Key tables, schema, page and tests take the classes from the union at the end.
"""

from typing import Annotated, Literal, TypeAlias, TypeVar, get_args

from pydantic import Field

from specs.spec import (
    Bounds,
    Coordinate,
    CornerAngle,
    Count,
    Distance,
    Duration,
    Offset,
    OrificeHeight,
    PositiveDistance,
    Spec,
    Speed,
    Tilt,
    Turn,
)

T = TypeVar("T", int, float)

HeightOrAuto: TypeAlias = OrificeHeight | Literal["auto"]
"""A height, or the one that suits the board's size and the nozzle; ``fit_recipe`` puts a number there."""

Overlap: TypeAlias = Annotated[float, Bounds(0, 0.99, what="parts of a footprint that lines share")]
RequiredTime: TypeAlias = Annotated[float, Bounds(0.01, 3600, "s", "times in the cone")]
Thickness: TypeAlias = Annotated[float, Bounds(0.001, 100_000, "µm", "thicknesses")]
Pitch: TypeAlias = Annotated[float, Bounds(0.1, 1000, "mm", "distances of lines")]

# One value, or one by component class with an optional `default`: `passes: {small: 2, large: 4, default: 2}`.
HeightByClass: TypeAlias = OrificeHeight | dict[str, OrificeHeight]
SpeedByClass: TypeAlias = Speed | dict[str, Speed]
OffsetByClass: TypeAlias = Offset | dict[str, Offset]
SecondsByClass: TypeAlias = Duration | dict[str, Duration]
TiltByClass: TypeAlias = Tilt | dict[str, Tilt]
CountByClass: TypeAlias = Count | dict[str, Count]


def for_class(value: T | dict[str, T], component_class: str) -> T:
    """Value of a class; a recipe that was read has one for each.

    Raises:
        KeyError: neither the class nor ``default`` is listed.
    """
    if not isinstance(value, dict):
        return value
    return value[component_class] if component_class in value else value["default"]


def height_of(spec: "BoardPerimeter | Raster | FinalFlush | StepFunction | StraightLine") -> float:
    """Height of a template of a fitted recipe, mm.

    Raises:
        ValueError: it is ``auto`` still.
    """
    if spec.height_mm == "auto":
        raise ValueError(f"{spec.path} has height_mm auto: the recipe was not fitted to a board.")
    return spec.height_mm


class _Path(Spec):
    """Keys of every template."""

    lead_in_mm: Distance = Field(
        default=0, description="Run-up before the path with the jet off, so that it opens at speed."
    )


class _OpenPath(_Path):
    """Keys of the paths that have two ends."""

    overshoot_mm: Distance = Field(default=0, description="How far the jet runs on past both ends of the path.")


class BoardPerimeter(_Path):
    """Follows the edge of the board."""

    path: Literal["board_perimeter"] = Field(
        default="board_perimeter", description="Path class: follows the edge of the board."
    )
    height_mm: HeightOrAuto = Field(
        description="Orifice above the board's surface; auto takes it from the board's size and the footprint."
    )
    speed_mm_s: Speed = Field(description="Speed of the orifice.")
    offset_mm: Offset = Field(default=0, description="Path outside the edge (+) or inside it (-).")
    repeats: Count = Field(default=1, description="How often it goes around.")
    tilt_deg: Tilt = Field(default=0, description="Jet from the board normal.")
    toward: Literal["inside", "outside", "travel", "against_travel"] = Field(
        default="inside", description="Which way the jet leans when tilted."
    )
    corner_delay_s: Duration = Field(default=0, description="Pause at each corner, jet on.")
    corner_deg: CornerAngle = Field(
        default=30, description="A bend of at least this much is a corner; smaller ones are followed without a pause."
    )
    direction: Literal["counterclockwise", "clockwise"] = Field(
        default="counterclockwise", description="Sense of travel, as seen from the top."
    )
    start: Literal["auto", "front_left", "front_right", "back_left", "back_right"] = Field(
        default="auto", description="Corner where it begins; auto takes the one that saves travel."
    )
    follow: Literal["outline", "outline_and_cutouts"] = Field(
        default="outline", description="The outer edge alone, or holes and slots of the board too."
    )


class _Lines(_OpenPath):
    """Keys of the paths made of parallel lines."""

    height_mm: HeightOrAuto = Field(
        description="Orifice above the board's surface; auto takes it from the board's size and the footprint."
    )
    speed_mm_s: Speed = Field(description="Speed of the orifice.")
    direction_deg: Turn | Literal["longest_edge", "across_longest_edge"] = Field(
        default=0, description="Direction of travel from +X, counterclockwise as seen from the top."
    )
    overlap: Overlap = Field(
        default=0.3, description="Part of the footprint's effective width that neighbouring lines share."
    )
    pitch_mm: Pitch | Literal["auto"] = Field(
        default="auto", description="Distance of neighbouring lines; auto takes it from the footprint and overlap."
    )
    margin_mm: Offset = Field(
        default=0, description="How far lines stay inside the board's edge (+) or run beyond it (-)."
    )
    tilt_deg: Tilt = Field(default=0, description="Jet from the board normal.")
    toward: Literal["travel", "against_travel", "left", "right"] = Field(
        default="travel", description="Which way the jet leans when tilted, seen in the direction of travel."
    )
    start: Literal["auto", "first", "last"] = Field(
        default="auto", description="Line to begin with: first is the rightmost seen along direction_deg."
    )
    repeats: Count = Field(default=1, description="How often the whole path is done.")


class Raster(_Lines):
    """Moves back and forth across the board."""

    path: Literal["raster"] = Field(default="raster", description="Path class: back and forth across the board.")
    edge_delay_s: Duration = Field(default=0, description="Pause at the end of each line, jet on.")


class FinalFlush(_Lines):
    """Traverses the board in one direction; returns with the jet off, above everything."""

    path: Literal["final_flush"] = Field(
        default="final_flush", description="Path class: across the board in one direction."
    )
    edge_delay_s: Duration = Field(default=0, description="Pause at the end of each line, jet on.")


class StepFunction(_Lines):
    """Traverses the board in one direction and pauses at each component edge crossed."""

    path: Literal["step_function"] = Field(
        default="step_function", description="Path class: one direction, with a pause at each component edge."
    )
    delay_s: SecondsByClass = Field(default=0.3, description="Pause at each edge of a component, jet on.")


class Near(Spec):
    """What changes for a component whose nearest neighbour is close."""

    within_mm: PositiveDistance = Field(description="Distance to the neighbour from which the values below hold.")
    speed_mm_s: Speed | None = Field(default=None, description="Replaces speed_mm_s of the template.")
    tilt_deg: Tilt | None = Field(default=None, description="Replaces tilt_deg of the template.")
    edge_delay_s: Duration | None = Field(default=None, description="Replaces edge_delay_s of the template.")
    distance_mm: Offset | None = Field(default=None, description="Replaces distance_mm of the template.")
    passes: Count | None = Field(default=None, description="Replaces passes of the template.")


class ComponentPerimeter(_Path):
    """Follows the edges of each component."""

    path: Literal["component_perimeter"] = Field(
        default="component_perimeter", description="Path class: follows the edges of each component."
    )
    height_mm: HeightByClass = Field(description="Orifice above the board's surface.")
    speed_mm_s: SpeedByClass = Field(description="Speed of the orifice.")
    align: Literal["wavefront", "axis"] = Field(
        default="wavefront", description="What is put on the edge: the near wave front of the tilted cone, or its axis."
    )
    distance_mm: OffsetByClass = Field(
        default=0, description="That line outside the component's edge (+) or inside (-)."
    )
    tilt_deg: TiltByClass = Field(default=30, description="Jet from the board normal.")
    toward: Literal["component", "away", "travel", "against_travel"] = Field(
        default="component", description="Which way the jet leans when tilted."
    )
    passes: CountByClass = Field(default=2, description="How often it goes around.")
    edge_delay_s: SecondsByClass = Field(default=0, description="Pause after each edge, jet on.")
    corner_deg: CornerAngle = Field(default=30, description="A bend of at least this much ends an edge.")
    merge_gap_mm: Distance = Field(default=2, description="Components closer than this are followed as one outline.")
    direction: Literal["auto", "counterclockwise", "clockwise"] = Field(
        default="auto", description="Sense of travel, as seen from the top."
    )
    near: Near | None = Field(default=None, description="Other values where neighbours are close.")
    only: list[str] = Field(default=[], description="Classes to serve; empty serves all.")


class StraightLine(_OpenPath):
    """One straight line between two points of the board."""

    path: Literal["straight_line"] = Field(
        default="straight_line", description="Path class: one line between two points."
    )
    from_mm: tuple[Coordinate, Coordinate] = Field(alias="from", description="Where the line begins, board frame, mm.")
    to_mm: tuple[Coordinate, Coordinate] = Field(alias="to", description="Where the line ends, board frame, mm.")
    height_mm: OrificeHeight = Field(description="Orifice above the board's surface.")
    speed_mm_s: Speed = Field(description="Speed of the orifice.")
    tilt_deg: Tilt = Field(default=0, description="Jet from the board normal.")
    toward: Literal["travel", "against_travel", "left", "right"] = Field(
        default="travel", description="Which way the jet leans when tilted, seen in the direction of travel."
    )
    repeats: Count = Field(default=1, description="How often it is done; back and forth.")
    edge_delay_s: Duration = Field(default=0, description="Pause at the end, jet on.")


class OverFaces(Spec):
    """Keys of the paths over the faces of a part: every visible point stays in the cone long enough (Sandia 1993)."""

    standoff_mm: OrificeHeight = Field(description="Orifice to surface, along the jet.")
    required_s: RequiredTime = Field(default=1.0, description="Time that every visible point is to be in the cone.")
    order: Literal["two_stage", "one_stage"] = Field(
        default="two_stage", description="Faces one after the other, or all stripes in one order."
    )
    incidence_min_deg: Annotated[float, Bounds(0, 85, "degrees", "angles of incidence")] = Field(
        default=30, description="Least angle between the jet and the surface."
    )
    tilt_max_deg: Annotated[float, Bounds(0, 85, "degrees", "tilts")] = Field(
        default=60, description="Largest tilt of the jet from the surface's normal, to avoid a collision."
    )
    repair: bool = Field(
        default=True,
        description="Choose each segment's speed by a linear program, and add poses where visible points lack time.",
    )


class Surface(OverFaces):
    """Stripes over the faces of a part (Sandia 1993, section 2)."""

    path: Literal["surface"] = Field(default="surface", description="Path class: stripes over the faces of a part.")
    striping: Literal["longest_edge", "fewest", "along", "contour"] = Field(
        default="longest_edge",
        description="Direction of the stripes of a plane face; curved faces are gone around in contours.",
    )
    along: tuple[Coordinate, Coordinate, Coordinate] = Field(
        default=(0, 0, 1), description="Direction of travel of striping along, in the part's frame."
    )
    width_mm: Pitch | Literal["auto"] = Field(
        default="auto",
        description=(
            "Largest width of a stripe; auto chooses stripes that take least time, of equal bands 0.71 of the "
            "footprint's diameter wide with repair: false."
        ),
    )


class Film(Spec):
    """A film that passes are to lay: how thick, how even, and how it is deposited."""

    thickness_um: Thickness = Field(description="Of the film, all repeats of the step together.")
    tolerance_um: Thickness = Field(description="By how much the film may be thinner or thicker anywhere.")
    deposited: Annotated[float, Bounds(0.001, 1, what="shares of the flow")] = Field(
        default=1.0, description="Share of the flow that stays as film: transfer efficiency times volume solids."
    )
    max_speed_mm_s: Speed | Literal["auto"] = Field(
        default="auto", description="Fastest speed of a pass; auto is the function's maximum."
    )
    speed_mm_s: Speed | Literal["auto"] = Field(
        default="auto", description="Speed before levelling; auto lays the thickness in the mean."
    )


class Slices(OverFaces):
    """Parallel curves over free-form faces, in a stated direction or the one in which there are the fewest."""

    path: Literal["slices"] = Field(
        default="slices", description="Path class: parallel curves over free-form faces of a part."
    )
    start: Literal["geodesic", "plane"] = Field(
        default="geodesic",
        description="A geodesic that halves the area of a face, and curves parallel to it on the surface; or planes.",
    )
    along: tuple[Coordinate, Coordinate, Coordinate] | Literal["auto"] = Field(
        default="auto", description="Direction of travel in the part's frame; auto takes that of the fewest curves."
    )
    slices: Count | Literal["auto"] = Field(
        default="auto", description="Number of curves on a face; auto takes as many as spacing_mm needs."
    )
    spacing_mm: Pitch | Literal["auto"] = Field(
        default="auto",
        description=(
            "Largest distance of neighbouring curves over the surface; auto takes 0.78 of the footprint's diameter, "
            "0.71 with repair: false. With film the distance itself; auto takes the one that is most even."
        ),
    )
    overshoot_mm: Distance | Literal["auto"] = Field(
        default="auto",
        description=(
            "How far the jet runs on past both ends of a curve that does not close; auto is 0, or with film the "
            "pattern's radius and a ramp."
        ),
    )
    film: Film | None = Field(
        default=None, description="An even film in place of a time in the cone: speeds are levelled along the passes."
    )


FacePath: TypeAlias = Surface | Slices
PathSpec: TypeAlias = Annotated[
    BoardPerimeter | Raster | ComponentPerimeter | FinalFlush | StepFunction | StraightLine | FacePath,
    Field(discriminator="path"),
]
PATH_CLASSES: tuple[type[PathSpec], ...] = get_args(get_args(PathSpec)[0])
"""The path classes, in the order of the union."""
BOARD_PATH_CLASSES = tuple(spec for spec in PATH_CLASSES if not issubclass(spec, OverFaces))
"""Those that are planned on boards."""
