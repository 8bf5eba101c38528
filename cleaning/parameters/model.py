"""Inputs of the model besides board and recipe: liquids, residue, film, gaps, limits, and how each is known."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from recipes.recipe import Use
from specs.spec import Bounds, Duration, Percent, Resistivity, Share, Spec, Spread

Word: TypeAlias = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
Celsius: TypeAlias = Annotated[float, Bounds(-100, 1000, "°C", "temperatures of liquids, parts and rooms")]
Contact: TypeAlias = Annotated[float, Bounds(0, 180, "degrees")]
Density: TypeAlias = Annotated[float, Bounds(0.01, 30_000, "kg/m³", "densities")]
Tension: TypeAlias = Annotated[float, Bounds(0.1, 1000, "mN/m", "surface tensions")]
Viscosity: TypeAlias = Annotated[float, Bounds(0.001, 100_000, "mPa·s", "viscosities")]
Exponent: TypeAlias = Annotated[float, Bounds(0.01, 10, what="exponents")]
Rate: TypeAlias = Annotated[float, Bounds(0, 10_000, "1/s", "rates")]
PositiveRate: TypeAlias = Annotated[float, Bounds(1e-9, 10_000, "1/s", "rates")]
Activation: TypeAlias = Annotated[float, Bounds(0, 1000, "kJ/mol", "energies of activation")]
PositivePercent: TypeAlias = Annotated[float, Bounds(0.0001, 100, "%", "concentrations")]
Shear: TypeAlias = Annotated[float, Bounds(0, 1_000_000, "Pa", "shears of a wall")]
PositiveShear: TypeAlias = Annotated[float, Bounds(1e-6, 1_000_000, "Pa", "shears of a wall")]
Impact: TypeAlias = Annotated[float, Bounds(0.001, 1_000_000, "kPa", "pressures of impact")]
Length: TypeAlias = Annotated[float, Bounds(0.001, 10_000, "mm", "lengths and depths of a film")]
Thin: TypeAlias = Annotated[float, Bounds(0.001, 100_000, "µm", "depths of films and gaps")]
Volume: TypeAlias = Annotated[float, Bounds(1e-6, 1_000_000, "mm", "depths of liquid that arrives")]
Hours: TypeAlias = Annotated[float, Bounds(0, 1_000_000, "h", "ages of residue")]
Minutes: TypeAlias = Annotated[float, Bounds(0, 100_000, "min", "times of a bake")]
PasteFactor: TypeAlias = Annotated[float, Bounds(0, 3)]
Coefficient: TypeAlias = Annotated[float, Bounds(0, 1000, what="coefficients")]
PositiveCoefficient: TypeAlias = Annotated[float, Bounds(0.001, 1000, what="coefficients")]
Reynolds: TypeAlias = Annotated[float, Bounds(0.001, 1_000_000, what="Reynolds numbers")]
Capacity: TypeAlias = Annotated[float, Bounds(1e-6, 100_000, "kg/m³", "loads of a liquid")]
HeatTransfer: TypeAlias = Annotated[float, Bounds(0.01, 1_000_000, "W/m²K", "heat transfers")]
Exchanges: TypeAlias = Annotated[float, Bounds(0.001, 1_000_000, what="numbers of exchanges")]
Litres: TypeAlias = Annotated[float, Bounds(0.0001, 1_000_000, "l", "volumes of tanks and of fresh water")]
Ionic: TypeAlias = Annotated[float, Bounds(1e-6, 1_000_000, "µg/cm²", "limits of ionic residue")]
Samples: TypeAlias = Annotated[int, Bounds(1, 1_000_000_000)]
Scatter: TypeAlias = Annotated[float, Bounds(0, 1e12, what="results of a fit")]
FitNumber: TypeAlias = Annotated[float, Bounds(-1e12, 1e12, what="results of a fit")]
Residue: TypeAlias = Literal["rosin", "no_clean", "water_soluble"]
Known: TypeAlias = Literal["source", "derived", "literature", "proposed", "calibrated", "synthetic"]


class Provenance(Spec):
    """Where values come from."""

    known: Known = Field(
        description="source: read there; derived: calculated; literature: believed, unchecked; proposed: ours; "
        "calibrated: fitted to the user's measurements; synthetic: fitted to made-up data."
    )
    source: str = Field(min_length=1, description="Document, measurement or reason.")
    date: str = Field(
        default="", pattern=r"^(\d{4}-\d{2}-\d{2})?$", description="Of the measurement, as in 2026-11-21."
    )
    samples: Samples | None = Field(default=None, description="Number of measurements that were fitted.")
    rms: Scatter | None = Field(default=None, description="Root mean square of what the fit leaves.")
    interval: tuple[FitNumber, FitNumber] | None = Field(default=None, description="95 % interval of the fitted value.")
    within_factor: Annotated[float, Bounds(1, 1000, what="factors within which a value lies")] | None = Field(
        default=None, description="Each value lies between itself divided and multiplied by this, for the capability."
    )


class Spray(Spec):
    """How liquid leaves an orifice."""

    discharge: Annotated[float, Bounds(0.01, 1)] = Field(description="Velocity coefficient of the orifice.")
    flow_exponent: dict[Literal["hollow_cone", "full_cone", "flat_fan", "air_knife", "radial"], Exponent] = Field(
        description="Flow goes with the pressure to this power, by pattern; left out for radial: as for full_cone."
    )
    cone_sigma_deg: Spread = Field(description="Softness of the edge of full cones and fans.")

    def exponent_of(self, pattern: str) -> float:
        """Power of the pressure with which the flow of a pattern goes."""
        known: dict[str, float] = {**self.flow_exponent}
        return known.get(pattern, known["full_cone"])


class Liquid(Spec):
    """A solution or gas, by the name that recipes use."""

    use: Use = Field(description="What it is for.")
    density_kg_m3: Density = Field(default=1000.0, description="At the process temperature.")
    surface_tension_mn_m: Tension | None = Field(
        default=None, description="Left out: that of pure water at the process temperature."
    )
    viscosity_mpa_s: Viscosity | None = Field(
        default=None, description="At 60 °C; left out: pure water's. It follows water's temperature either way."
    )
    contact_board_deg: Contact = Field(default=75.0, description="Advancing contact angle on the board.")
    contact_part_deg: Contact = Field(default=75.0, description="Advancing contact angle on the component.")
    concentration_pct: Percent = Field(
        default=0.0, description="Of the cleaning agent; 100 where the liquid itself dissolves the residue."
    )
    bath_nvr_pct: Percent = Field(default=0.0, description="Non-volatile residue that the bath carries.")
    resistivity_mohm_cm: Resistivity | None = Field(default=None, description="Of rinse water as it is sprayed.")
    window_c: tuple[Celsius, Celsius] | None = Field(default=None, description="Temperatures at which it may be used.")
    concentration_window_pct: tuple[Percent, Percent] | None = Field(
        default=None, description="Concentrations at which it may be used."
    )
    dissolves: list[Residue] = Field(default=[], description="Kinds of flux that it removes; left out: not judged.")
    attacks: list[Word] = Field(default=[], description="Materials that it attacks, such as aluminium.")


class Film(Spec):
    """The film that runs from the wave front across the board."""

    retention: Share = Field(description="Share of momentum that survives the impact (chi).")
    decay_mm: Length = Field(description="Length over which the film's momentum falls to 1/e (l).")
    puddle_mm: Length = Field(description="Depth of liquid that the film ploughs into at an edge (d_p).")
    lee: Share = Field(description="Suction coefficient of a lee edge (c_lee).")
    shelter: Share = Field(description="Share that is left behind an upstream component (S).")
    shelter_mm: Length = Field(description="How near that component must be.")
    hold_s: Duration = Field(description="How long a pressure must be held to open a gap.")


class Soil(Spec):
    """What is to be removed, and how it gives way."""

    flux: Residue | None = Field(default=None, description="Kind of flux; left out: whether a solution suits is open.")
    k1_per_s: PositiveRate = Field(description="Softening by chemistry at 60 °C and the reference concentration.")
    activation_kj_mol: Activation = Field(description="Of the softening.")
    half_pct: PositivePercent = Field(description="Concentration at which softening is half of its limit.")
    reference_pct: PositivePercent = Field(description="Concentration at which k1_per_s holds.")
    k_m_per_s: Rate = Field(description="Removal of what is soft, at the reference shear.")
    shear_reference_pa: PositiveShear = Field(description="Wall shear at which k_m_per_s holds.")
    shear_exponent: Exponent = Field(description="Removal goes with the shear to this power.")
    shear_threshold_pa: Shear = Field(description="Below it nothing is removed.")
    density_kg_m3: Density = Field(description="Of the residue.")
    retained: Share = Field(description="Share of the printed flux that stays after reflow, for f0.")
    paste_factor: PasteFactor = Field(description="Venting and spatter: scales f0.")
    front_um: Thin = Field(description="Depth over which a plugged gap softens from its rim (l_s).")
    age_h: Hours | None = Field(default=None, description="Hours from reflow to washing; left out: unknown.")


class Gap(Spec):
    """Flow in thin gaps."""

    cells: Annotated[int, Bounds(4, 200)] = Field(description="Cells of a gap along each side.")
    entrance_loss: Coefficient = Field(description="Entrance and exit loss (zeta).")
    most_reynolds: Reynolds = Field(description="Reduced Reynolds number above which flow counts at its lower bound.")
    thickest_um: Thin = Field(description="Higher gaps are treated as exposed.")
    plugged: Share = Field(description="Fill above which nothing flows through.")
    capacity_kg_m3: Capacity = Field(description="Residue that a cubic metre of liquid can carry (c_cap).")


class RinseTank(Spec):
    """One of the tanks that a board is rinsed from."""

    solution: Word = Field(description="Its water, by the name that recipes use.")
    volume_l: Litres = Field(description="Water that circulates.")


class RinseCascade(Spec):
    """Rinse tanks that boards pass one after the other, each with what they carry over from the one before."""

    tanks: list[RinseTank] = Field(min_length=1, max_length=12, description="In the order in which boards pass them.")
    fresh_l: Litres = Field(description="Fresh water for each board: into the last tank, or into each.")
    feed: Literal["counter_current", "each"] = Field(
        default="counter_current",
        description="counter_current: fresh water enters the last tank and overflows from tank to tank; each: every "
        "tank has its own.",
    )


class Rinse(Spec):
    """Dilution of what the wash leaves."""

    film_um: Thin = Field(description="Film on exposed surfaces that one exchange replaces.")
    final_film_um: Thin = Field(description="Film that stays when the rinse ends.")
    efficiency: Share = Field(description="Of an exchange (eta).")
    cascade: RinseCascade | None = Field(
        default=None, description="Tanks whose water is used for many boards; left out: each rinse has fresh water."
    )


class Drying(Spec):
    """Blow-off and evaporation."""

    receding_deg: Contact = Field(description="Contact angle of the rear of a moving drop.")
    advancing_deg: Contact = Field(description="Contact angle of its front.")
    pressure_coefficient: PositiveCoefficient = Field(description="Difference of c_p across a part (dC_p).")
    residual_film_um: Thin = Field(description="Film that blow-off leaves.")
    transfer_w_m2_k: HeatTransfer = Field(description="Heat transfer to the board while it is blown on.")
    room_c: Celsius = Field(description="Air that is heated for drying.")
    room_humidity_pct: Percent = Field(description="Of that air.")
    dwell_min: Minutes = Field(default=0.0, description="How long the board stays in the warm air after the program.")
    bake_c: Celsius | None = Field(default=None, description="Temperature of a bake that follows; left out: none.")
    bake_min: Minutes = Field(default=0.0, description="How long.")


class PartOverride(Spec):
    """What is known of some components better than from their package family. The first that matches counts."""

    match: list[str] = Field(min_length=1, description="Patterns of reference designators or packages, such as QFN*.")
    standoff_um: tuple[Thin, Thin] | None = Field(default=None, description="Lowest and highest.")
    paste_factor: PasteFactor | None = Field(default=None, description="Scales its f0.")
    most_kpa: Impact | None = Field(default=None, description="Impact pressure that it bears.")
    window_c: tuple[Celsius, Celsius] | None = Field(default=None, description="Temperatures that it bears.")
    materials: list[Word] = Field(default=[], description="Bare materials that a solution must not attack.")


class Limits(Spec):
    """What counts as clean."""

    wash_volume_mm: Volume = Field(description="Least solution on an exposed surface in washing.")
    rinse_volume_mm: Volume = Field(description="Least water on an exposed surface in rinsing.")
    front_s: Duration = Field(description="Least time in the wave front in washing.")
    gap_marginal: Share = Field(description="Residue under a part above which it is marginal.")
    gap_dirty: Share = Field(description="Residue under a part above which it is dirty.")
    margin: Annotated[float, Bounds(1, 100, what="margins")] = Field(
        default=2,
        description="A part is clean with so many times the least volumes, and with gap_marginal divided by it.",
    )
    pocket: Share = Field(description="Residue of the worst tenth of a gap above which there is a pocket.")
    weak_shear_pa: Shear = Field(description="Wall shear below which a place is not flushed.")
    weak_share: Share = Field(description="Share of a gap that may be below it.")
    exchanges: Exchanges = Field(description="Least exchanges of water under a part in rinsing.")
    rinse_warn_mohm: Resistivity = Field(description="Resistivity of the water below which to warn.")
    rinse_fail_mohm: Resistivity = Field(description="Resistivity of the water below which it fails.")
    bath_nvr_pct: PositivePercent = Field(description="Non-volatile residue above which the bath is changed.")
    ionic_ug_cm2: Ionic | None = Field(default=None, description="The user's own limit; left out: none.")
    hours_after_reflow: Annotated[float, Bounds(0.01, 1_000_000, "h", "ages of residue")] | None = Field(
        default=None, description="Oldest residue that may be washed; out: any."
    )


class Parameters(Spec):
    """A parameter set of the cleaning model: one YAML file."""

    parameters: Word = Field(description="Name of the set.")
    description: str = Field(default="", description="What it holds for.")
    extends: str | None = Field(default=None, description="Set whose keys are inherited: a library name or a file.")
    spray: Spray
    liquids: dict[Word, Liquid] = Field(min_length=1, description="Solutions and gases by the name in recipes.")
    soil: Soil
    film: Film
    gap: Gap
    rinse: Rinse
    drying: Drying
    parts: list[PartOverride] = Field(default=[], description="What is known of some components.")
    limits: Limits
    provenance: dict[str, Provenance] = Field(
        description="Where values come from, by path such as soil.k1_per_s; a block's covers all within it."
    )

    @property
    def calibrated(self) -> bool:
        """Whether the kinetics were fitted to real measurements: the grade of verdicts on residue depends on it."""
        return all(self.known(f"soil.{name}").known == "calibrated" for name in ("k1_per_s", "k_m_per_s"))

    def known(self, path: str) -> Provenance:
        """Find where a value comes from: its own entry, else that of the nearest block around it."""
        while path:
            if path in self.provenance:
                return self.provenance[path]
            path = path.rpartition("[" if path.endswith("]") else ".")[0]
        return _UNSTATED


_UNSTATED = Provenance(known="proposed", source="not stated in the parameter set")
