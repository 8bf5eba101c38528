"""An independent reader of programs: it parses the text by itself and knows nothing of Washboard but the format.

It imports nothing of the house, so that a mistake there cannot hide itself here. Each check is a pure function that
returns what it found; an empty list is a pass. Millimetres, seconds, degrees; what concerns space is in
``judge_space.py``.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IsMaker = Callable[[str], bool]

POSITION_ROUNDING_MM = 0.5e-3 * 3**0.5  # half a micrometre in each coordinate
ANGLE_ROUNDING_RAD = 4e-7  # 1e-7 in each component of a quaternion


@dataclass(frozen=True, eq=False)
class Track:
    """A program as key poses: every MOVE, and the held pose at the end of every WAIT."""

    header: dict[str, list[str]]
    line_times: Array  # (lines,) of every instruction
    times: Array  # (k,)
    tcp: Array  # (k, 3)
    quaternion: Array  # (k, 4)
    stated_speed: Array  # (k,) NaN at the end of a wait
    makers: list[str]  # (k,) who asked for the segment that ends here
    functions: list[str]  # (k,) which function holds then
    waits: list[tuple[float, float, str]]  # begin, length, maker
    on: list[tuple[float, float]]  # when the jet is on
    on_at_end: bool

    @property
    def lengths(self) -> Array:
        """(k - 1,) of the segments."""
        return np.linalg.norm(np.diff(self.tcp, axis=0), axis=1)

    @property
    def approach(self) -> Array:
        """(k, 3) unit vectors along the jet."""
        w, x, y, z = self.quaternion.T
        return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)

    @property
    def sprayed_s(self) -> Array:
        """(k - 1,) for how long the jet is on in each segment."""
        edges = np.array(self.on).reshape(-1)
        if not len(edges):
            return np.zeros(len(self.times) - 1)
        passed = np.concatenate([[0.0], np.cumsum(np.diff(edges) * (np.arange(len(edges) - 1) % 2 == 0))])
        return np.diff(np.interp(self.times, edges, passed))


def read_track(text: str) -> Track:
    """Read the text of a ``.wash`` file."""
    head, body = text.split("\nBEGIN\n")
    header = {line.split()[0]: line.split()[1:] for line in head.split("\n") if not line.startswith("LIQUID")}
    lines = body.split("\n")
    assert lines[-2:] == ["END", ""], "the program does not end with END"
    poses: list[tuple[float, list[float], float, str, str]] = []
    line_times: list[float] = []
    waits: list[tuple[float, float, str]] = []
    switches: list[tuple[float, bool]] = []
    function = ""
    for line in lines[:-2]:
        words, _, maker = line.partition(" ; ")
        stamp, keyword, *arguments = words.split()
        line_times.append(float(stamp))
        if keyword == "MOVE":
            numbers = [float(word) for word in arguments]
            poses.append((float(stamp), numbers[:7], numbers[7], maker, function))
        elif keyword == "WAIT":
            waits.append((float(stamp), float(arguments[0]), maker))
            poses.append((float(stamp) + float(arguments[0]), poses[-1][1], float("nan"), maker, function))
        elif keyword == "SPRAY":
            switches.append((float(stamp), arguments == ["ON"]))
        elif keyword == "FUNCTION":
            function = arguments[0]
    pose = np.array([numbers for _, numbers, _, _, _ in poses])
    return Track(
        header=header,
        line_times=np.array(line_times),
        times=np.array([stamp for stamp, *_ in poses]),
        tcp=pose[:, :3],
        quaternion=pose[:, 3:],
        stated_speed=np.array([speed for _, _, speed, _, _ in poses]),
        makers=[maker for *_, maker, _ in poses],
        functions=[holds for *_, holds in poses],
        waits=waits,
        on=_on_intervals(switches, line_times[-1]),
        on_at_end=bool(switches) and switches[-1][1],
    )


def _on_intervals(switches: list[tuple[float, bool]], end: float) -> list[tuple[float, float]]:
    intervals: list[tuple[float, float]] = []
    opened: float | None = None
    for stamp, on in [*switches, (end, False)]:
        if on and opened is None:
            opened = stamp
        elif not on and opened is not None:
            intervals.append((opened, stamp))
            opened = None
    return intervals


def times_running_back(track: Track) -> list[str]:
    """Instructions earlier than the one before them, and waits that are cut short."""
    found = [f"instruction {i + 2} runs back" for i in np.flatnonzero(np.diff(track.line_times) < 0)]
    return found + [
        f"{track.times[i]:.4f} s: a wait is cut short" for i in np.flatnonzero(np.diff(track.times) < -1e-9)
    ]


def wrong_totals(track: Track) -> list[str]:
    """Totals that disagree with the instructions by more than their rounding."""
    words = track.header["TOTALS"]
    stated = {key: float(value) for key, value in zip(words[::2], words[1::2], strict=True)}
    moves = int(np.isfinite(track.stated_speed).sum())
    found = {
        "duration_s": (track.times[-1], 2e-4),
        "spray_s": (sum(end - begin for begin, end in track.on), 2e-4 * (len(track.on) + 1)),
        "travel_mm": (track.lengths.sum(), 2e-3 * (moves + 1)),
        "moves": (moves, 0.5),
    }
    return [
        f"{key} is stated as {stated[key]:g} and is {value:g}"
        for key, (value, tolerance) in found.items()
        if abs(stated[key] - value) > tolerance
    ]


def too_fast(track: Track, max_speed: dict[str, float], share: float = 1e-3) -> list[str]:
    """Segments faster than the maximum of the function that holds."""
    limits = np.array([max_speed.get(function, np.inf) for function in track.functions[1:]])
    speeds = _speeds(track)
    return [
        f"{track.times[i + 1]:.4f} s: {speeds[i]:.3f} mm/s, {track.functions[i + 1]} allows {limits[i]:g}"
        for i in np.flatnonzero(speeds > limits * (1 + share))
    ]


def wrong_stated_speeds(track: Track) -> list[str]:
    """Moves whose stated speed is not the mean speed of their segment, as far as rounding lets one see."""
    speeds = _speeds(track)
    lasting = np.maximum(np.diff(track.times), 1e-9)
    tolerance = 1e-3 + (2 * POSITION_ROUNDING_MM + speeds * 1e-4) / lasting
    wrong = np.abs(track.stated_speed[1:] - speeds) > tolerance  # NaN, the end of a wait, is not wrong
    return [
        f"{track.times[i + 1]:.4f} s: states {track.stated_speed[i + 1]:.3f} mm/s, is {speeds[i]:.3f}"
        for i in np.flatnonzero(wrong & np.isfinite(speeds))
    ]


def _speeds(track: Track) -> Array:
    """(k - 1,) mean speed; infinite for a jump."""
    lasting, lengths = np.diff(track.times), track.lengths
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(lengths > 2 * POSITION_ROUNDING_MM, lengths / np.maximum(lasting, 0.0), 0.0)


def too_sharp(
    track: Track, acceleration: float, windows_s: tuple[float, ...] = (0.0, 0.02, 0.08), time_rounding_s: float = 5e-5
) -> list[str]:
    """Moments at which the orifice accelerates more than allowed, beyond what rounding can pretend.

    The divided second difference over three poses is twice a weighted mean of the acceleration between them, whatever
    their distance in time; wide windows feel the rounding less, narrow ones see short peaks.
    """
    found: list[str] = []
    for window in windows_s:
        before, here, after = _triples(track.times, window)
        h1, h2 = track.times[here] - track.times[before], track.times[after] - track.times[here]
        v1 = (track.tcp[here] - track.tcp[before]) / h1[:, None]
        v2 = (track.tcp[after] - track.tcp[here]) / h2[:, None]
        measured = 2 * np.linalg.norm(v2 - v1, axis=1) / (h1 + h2)
        blur = (2 * POSITION_ROUNDING_MM + 2 * time_rounding_s * np.linalg.norm(v1, axis=1)) / h1
        blur += (2 * POSITION_ROUNDING_MM + 2 * time_rounding_s * np.linalg.norm(v2, axis=1)) / h2
        tolerance = 2 * blur / (h1 + h2) + acceleration * (0.005 + 2 * time_rounding_s / (h1 + h2))
        found += [
            f"{track.times[here[i]]:.4f} s: {measured[i]:.0f} mm/s2 over {h1[i] + h2[i]:.4f} s"
            for i in np.flatnonzero(measured > acceleration + tolerance)
        ]
    return found


def _triples(times: Array, window_s: float) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """For each pose the last one at least a window earlier and the first one at least a window later."""
    distinct = np.flatnonzero(np.concatenate([[True], np.diff(times) > 1e-9]))
    grid = times[distinct]
    reach = max(window_s, 1e-9)
    before = np.searchsorted(grid, grid - reach, side="right") - 1
    after = np.searchsorted(grid, grid + reach, side="left")
    here = np.flatnonzero((before >= 0) & (after < len(grid)))
    return distinct[before[here]], distinct[here], distinct[after[here]]


def turning_too_fast(track: Track, rotation_deg_s: float) -> list[str]:
    """Segments in which the nozzle turns faster than allowed."""
    lasting, angles = np.diff(track.times), _angles(track)
    allowed = np.radians(rotation_deg_s) * (lasting * 1.002 + 1e-4) + 2 * ANGLE_ROUNDING_RAD
    return [
        f"{track.times[i + 1]:.4f} s: turns {np.degrees(angles[i]):.3f} deg in {lasting[i]:.4f} s"
        for i in np.flatnonzero(angles > allowed)
    ]


def turning_too_sharply(track: Track, acceleration_deg_s2: float) -> list[str]:
    """Moments at which the rate of turning changes faster than allowed; the axis may change."""
    distinct = np.flatnonzero(np.concatenate([[True], np.diff(track.times) > 1e-9]))
    turned = np.concatenate([[0.0], np.cumsum(_angles(track))])[distinct]
    before, here, after = _triples(track.times[distinct], 0.02)
    times = track.times[distinct]
    h1, h2 = times[here] - times[before], times[after] - times[here]
    rate1, rate2 = (turned[here] - turned[before]) / h1, (turned[after] - turned[here]) / h2
    measured = 2 * np.abs(rate2 - rate1) / (h1 + h2)
    blur = (2 * ANGLE_ROUNDING_RAD + 1e-4 * rate1) / h1 + (2 * ANGLE_ROUNDING_RAD + 1e-4 * rate2) / h2
    allowed = np.radians(acceleration_deg_s2) * 1.01 + 2 * blur / (h1 + h2)
    return [f"{times[here[i]]:.4f} s: {np.degrees(measured[i]):.0f} deg/s2" for i in np.flatnonzero(measured > allowed)]


def _angles(track: Track) -> Array:
    a, b = track.quaternion[:-1], track.quaternion[1:]
    b = np.where(np.sum(a * b, axis=1, keepdims=True) < 0, -b, b)
    return 4 * np.arctan2(np.linalg.norm(b - a, axis=1), np.linalg.norm(b + a, axis=1))


def is_transfer(maker: str) -> bool:
    """Say whether a recipe path asks for a move with the jet off."""
    return maker.endswith(("/transfer", "/park", "/start", "/turn"))


def spraying_in_transfers(track: Track, is_dry: IsMaker = is_transfer) -> list[str]:
    """Transfers that move while the jet is on; the last tenth of a millisecond is rounding."""
    sprayed = track.sprayed_s
    wet = (sprayed > 1.5e-4) & (track.lengths > 2 * POSITION_ROUNDING_MM)
    return [
        f"{track.times[i + 1]:.4f} s: sprays {sprayed[i]:.4f} s in {track.makers[i + 1]}"
        for i in np.flatnonzero(wet)
        if is_dry(track.makers[i + 1])
    ]


def jet_on_at_end(track: Track) -> list[str]:
    """Whether the last switch leaves the jet on."""
    return ["the jet is on at the end"] if track.on_at_end else []
