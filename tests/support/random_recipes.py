"""Hypothesis strategies over everything a recipe may state; those of templates follow the union of path classes."""

from typing import Literal, get_args, get_origin

from hypothesis import assume
from hypothesis import strategies as st

from recipes.consistency import find_problems
from recipes.paths import BOARD_PATH_CLASSES
from recipes.recipe import Recipe

CLASSES = {"tall": {"height_mm": {"min": 10}}, "small": {"area_mm2": {"max": 5}}, "others": {}}
NOZZLES = {
    "cone": {"pattern": "hollow_cone", "half_angle_deg": 25, "flow_lpm": 2},
    "wide": {"pattern": "full_cone", "half_angle_deg": 40, "flow_lpm": 2},
    "gun": {"pattern": "radial", "radius_mm": 40, "at_mm": 100, "flow_lpm": 2},
    "fan": {"pattern": "flat_fan", "half_angle_deg": 30, "flow_lpm": 3},
    "knife": {"pattern": "air_knife", "width_mm": 30, "flow_lpm": 300},
}
LIMITS = st.fixed_dictionaries(
    {},
    optional={
        "acceleration_mm_s2": st.sampled_from([50, 500, 4000]),
        "rotation_deg_s": st.sampled_from([20, 180, 720]),
        "rotation_acceleration_deg_s2": st.sampled_from([60, 1800, 20000]),
        "transfer_speed_mm_s": st.sampled_from([15, 250, 900]),
        "blend_mm": st.sampled_from([0, 0.05, 0.5, 4]),
        "clearance_mm": st.sampled_from([0.5, 2, 5, 9]),
        "park_height_mm": st.sampled_from([10, 110, 300]),
        "park_mm": st.sampled_from([[-40, 300], [20, 10]]),
        "tool_azimuth_deg": st.sampled_from([0, 33.3, -170]),
    },
)
SPEEDS = st.sampled_from([0.7, 12, 40, 99.9])
DELAYS = st.sampled_from([0, 0.0003, 0.25, 1.7])
TILTS = st.sampled_from([0, 10, 26, 38])


def by_class(values):
    """One value, or one by class."""
    listed = st.fixed_dictionaries({"default": values}, optional={"tall": values, "small": values})
    return values | listed


HEIGHTS = st.sampled_from([9.5, 20, 50])
VALUES = {
    "height_mm": HEIGHTS,
    "speed_mm_s": SPEEDS,
    "tilt_deg": TILTS,
    "lead_in_mm": st.sampled_from([0, 3, 25]),
    "overshoot_mm": st.sampled_from([0, 0.4, 12]),
    "repeats": st.sampled_from([0, 1, 3]),
    "edge_delay_s": DELAYS,
    "corner_delay_s": DELAYS,
    "delay_s": DELAYS,
    "offset_mm": st.sampled_from([0, 6, -4, -200]),
    "corner_deg": st.sampled_from([5, 30, 120]),
    "direction_deg": st.sampled_from([0, 90, 17.3, -135, "longest_edge", "across_longest_edge"]),
    "overlap": st.sampled_from([0, 0.3, 0.8]),
    "pitch_mm": st.sampled_from(["auto", 7, 60]),
    "margin_mm": st.sampled_from([0, 4, 40, -8]),
    "from": st.just([-5, 12]),
    "to": st.sampled_from([[70, 12], [30, 44], [-5, 12.5]]),
    "distance_mm": st.sampled_from([0, 2.5, -1, -30]),
    "passes": st.sampled_from([0, 1, 2, 5]),
    "merge_gap_mm": st.sampled_from([0, 2, 9]),
    "near": st.just({"within_mm": 6, "speed_mm_s": 8, "passes": 3, "tilt_deg": 12}),
    "only": st.sampled_from([[], ["tall"], ["small", "others"]]),
}
"""Values by key; a key of choices has all of them. One that is not here keeps its default, or takes a number."""
NUMBERS = st.sampled_from([2, 7])


def template_of(spec):
    """Templates of a path class: what it needs, with some of its other values."""
    required, optional = {"path": st.just(spec.model_fields["path"].default)}, {}
    for name, field in spec.model_fields.items():
        key, kinds = field.alias or name, get_args(field.annotation)
        listed = any(get_origin(kind) is dict for kind in kinds)
        values = st.sampled_from(kinds) if get_origin(field.annotation) is Literal else VALUES.get(key)
        if field.is_required():
            needed = NUMBERS if values is None else values
            required[key] = by_class(needed) if listed else needed
        elif values is not None and key != "path":
            optional[key] = by_class(values) if listed else values
    return st.fixed_dictionaries(required, optional=optional)


TEMPLATES = st.one_of(*(template_of(spec) for spec in BOARD_PATH_CLASSES))
NAMES = ["one", "two", "three"]
STEPS = st.fixed_dictionaries(
    {
        "function": st.sampled_from(["wash", "dry"]),
        "nozzle": st.sampled_from(list(NOZZLES)),
        "paths": st.lists(st.sampled_from(NAMES), min_size=1, max_size=3),
    },
    optional={
        "side": st.sampled_from(["top", "bottom"]),
        "repeat": st.sampled_from([1, 2]),
        "enabled": st.sampled_from([True, True, False]),
    },
) | st.fixed_dictionaries(
    {
        "function": st.just("wash"),
        "nozzle": st.just("cone"),
        "paths": st.lists(st.sampled_from(NAMES), min_size=1, max_size=2),
        "until": st.just({"resistivity_mohm_cm": 1.0, "max_repeats": 3}),
    }
)
MASKS = st.lists(
    st.sampled_from(
        [
            {"avoid": ["U1"], "margin_mm": 1.0},
            {"avoid": ["C*"], "margin_mm": 6.0},
            {"ignore": ["J*"]},
            {"clean": ["U*"]},
            {"avoid": ["NOT_THERE"]},
        ]
    ),
    max_size=2,
)


@st.composite
def recipes(draw):
    """Recipes that a check of recipes lets through."""
    recipe = Recipe.model_validate(
        {
            "recipe": "random",
            "functions": {
                "wash": {"solution": "water", "pressure_bar": 2, "max_speed_mm_s": 100},
                "dry": {"solution": "air", "pressure_bar": 4, "max_speed_mm_s": 100, "solution_kind": "gas"},
            },
            "nozzles": NOZZLES,
            "classes": CLASSES,
            "masks": draw(MASKS),
            "templates": {name: draw(TEMPLATES) for name in NAMES},
            "limits": draw(LIMITS),
            "sequence": draw(st.lists(STEPS, min_size=1, max_size=3)),
        }
    )
    assume(not find_problems(recipe))
    return recipe
