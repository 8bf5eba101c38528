"""Made-up measurements of which the truth is known: spray patterns and coupons."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Ring:
    """A hollow cone whose half angle varies about its axis. Degrees."""

    half_angle: float = 31.2
    sigma: float = 2.7
    waves: tuple[float, ...] = ()
    gain: tuple[float, ...] = ()

    def middle(self, azimuth: float) -> float:
        return self.half_angle + wave(self.waves, azimuth)


def wave(amplitudes: Sequence[float], azimuth: float) -> float:
    pairs = zip(amplitudes[::2], amplitudes[1::2], strict=True)
    return sum(c * math.cos(k * azimuth) + s * math.sin(k * azimuth) for k, (c, s) in enumerate(pairs, 1))


def seen_from_nozzle(height: float, tilt: float, x: float, y: float) -> tuple[float, float, float, float]:
    """Polar angle (degrees), azimuth (rad), distance and cosine of incidence of a place on a sheet.

    Worked out in the room, z up: the nozzle points down and is turned about y until it leans towards +x, and y of the
    sheet, clockwise as seen from the nozzle, is -y of the room.
    """
    lean = Rotation.from_euler("y", -tilt, degrees=True)
    tool_x, tool_z = lean.apply([1.0, 0.0, 0.0]), lean.apply([0.0, 0.0, -1.0])
    tool_y = np.cross(tool_z, tool_x)
    hit = height / -tool_z[2] * tool_z
    orifice = -hit
    ray = np.array([x, -y, 0.0]) - orifice
    distance = float(np.linalg.norm(ray))
    along = float(ray @ tool_z)
    azimuth = math.atan2(float(ray @ tool_y), float(ray @ tool_x))
    return math.degrees(math.acos(min(along / distance, 1.0))), azimuth, distance, height / distance


def edge(ring: Ring, height: float, tilt: float, azimuth_deg: float, sigmas: float) -> float:
    """Radius at which the ring's profile has fallen off by so many sigmas."""
    around = math.radians(azimuth_deg)

    def beyond(radius: float) -> float:
        polar, azimuth, _, _ = seen_from_nozzle(height, tilt, radius * math.cos(around), radius * math.sin(around))
        return polar - ring.middle(azimuth) - sigmas * ring.sigma

    return float(brentq(beyond, 0.0, 2000.0))


SHEETS = ((40.0, 0.0), (80.0, 0.0), (40.0, 20.0), (80.0, 20.0))


def edge_table(ring: Ring, *, noise_mm: float, seed: int, step_deg: int = 30, first: str = "# synthetic") -> str:
    random = np.random.default_rng(seed)
    lines = [first, "height_mm,tilt_deg,azimuth_deg,inner_mm,outer_mm"]
    for height, tilt in SHEETS:
        for azimuth in range(0, 360, step_deg):
            inner, outer = (
                edge(ring, height, tilt, azimuth, side) + random.normal(0.0, noise_mm) for side in (-2.0, 2.0)
            )
            lines.append(f"{height:g},{tilt:g},{azimuth},{inner:.2f},{outer:.2f}")
    return "\n".join(lines) + "\n"


def intensity_table(ring: Ring, *, noise: float, seed: int, power: int = 1) -> str:
    random = np.random.default_rng(seed)
    lines = ["# synthetic", "height_mm,tilt_deg,x_mm,y_mm,intensity"]
    for height, tilt in ((40.0, 0.0), (70.0, 20.0)):
        reach = 1.3 * edge(ring, height, tilt, 0.0, 2.0)
        places = [(x, y) for x in np.linspace(-reach, reach, 25) for y in np.linspace(-reach, reach, 25)]
        strengths = []
        for x, y in places:
            polar, azimuth, distance, cosine = seen_from_nozzle(height, tilt, x, y)
            profile = math.exp(-0.5 * ((polar - ring.middle(azimuth)) / ring.sigma) ** 2)
            strengths.append((1 + wave(ring.gain, azimuth)) * profile * cosine**power / distance**2)
        scale = height / max(strengths)
        for (x, y), strength in zip(places, strengths, strict=True):
            value = max(0.0, scale * strength + height * random.normal(0.0, noise))
            lines.append(f"{height:g},{tilt:g},{x:.2f},{y:.2f},{value:.4f}")
    return "\n".join(lines) + "\n"


def written(folder: Path, text: str, name: str = "data.csv") -> Path:
    file = folder / name
    file.write_text(text, "utf-8")
    return file


COUPON_HEADER = "standoff_um,time_s,temperature_c,pressure_bar,cleaned_fraction"
PLAN = [
    (standoff, seconds, celsius, bar)
    for standoff in (25, 50, 100, 200)
    for seconds in (60, 180, 420)
    for celsius in (45, 60)
    for bar in (1.5, 3.5)
]
"""Standoffs, times, temperatures and pressures of a small set of coupons."""


def coupon_table(cleaned: Sequence[float], *, noise: float, seed: int, first: str = "# synthetic") -> str:
    """The plan with what was cleaned, as read off a photograph: between 0 and 1, with three places."""
    random = np.random.default_rng(seed)
    lines = [first, COUPON_HEADER]
    for (standoff, seconds, celsius, bar), share in zip(PLAN, cleaned, strict=True):
        seen = min(1.0, max(0.0, share + random.normal(0.0, noise)))
        lines.append(f"{standoff},{seconds},{celsius},{bar},{seen:.3f}")
    return "\n".join(lines) + "\n"
