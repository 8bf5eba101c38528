"""Analog channels: volts or mA at the terminal, and the numbers that each language counts for them."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from programs.motion.installation import Channel, Sensor
from programs.motion.steps import Line, Repeat, Step, Switch
from specs.finding import Finding
from specs.finding_rules import ANALOG_OUT_OF_RANGE

_SLACK = 1e-6
"""Of the full scale: the last digits of a value that is exactly there."""


@dataclass(frozen=True, slots=True)
class Counting:
    """How a language counts an analog channel; by default in the channel's own unit."""

    full: float = 0.0
    """Its number at full scale; 0 where it counts in the channel's own unit. Where numbers are whole a channel may
    state its own, because the module decides."""
    step: float = 1e-6
    """Smallest difference between two numbers: 1 where they are whole."""
    least: float = -math.inf
    """The lowest number it takes; none is lower than that of the full scale, reversed."""
    zero_ma: float = 0.0
    """Value of its 0 on a channel of mA: 4 where the controller counts from 4 to 20 mA."""
    reads_amperes: bool = False
    """Whether inputs are read in volts or amperes, whatever outputs count."""

    def count(self, channel: Channel | Sensor, value: float) -> float:
        """Convert a value in the channel's own unit to the language's number."""
        zero, gain = self._line(channel)
        return round((value - zero) * gain / self.step) * self.step

    def value(self, channel: Channel | Sensor, count: float) -> float:
        """Convert the language's number to a value in the channel's own unit."""
        zero, gain = self._line(channel)
        return zero + count / gain

    def reading(self, sensor: Sensor) -> tuple[float, float]:
        """Scale and offset such that ``scale * number + offset`` is the quantity that a sensor shows."""
        zero, gain = self._line(sensor)
        return sensor.scale / gain, sensor.offset + sensor.scale * zero

    def lowest(self, channel: Channel | Sensor) -> float:
        """Lowest value that the language can express, in the channel's own unit."""
        return max(-channel.full_scale, self.value(channel, self.least))

    def tolerance(self, channel: Channel | Sensor) -> float:
        """Largest error by rounding, in the channel's own unit."""
        return 0.5 * self.step / self._line(channel)[1] + _SLACK * channel.full_scale

    def describe(self, channel: Channel | Sensor) -> str:
        """Describe the numbers, such as ``aoPressure: 0 V is 0, 10 V is 2000``."""
        zero, full = self._line(channel)[0], channel.full_scale
        low, high = (f"{value:g} {channel.unit} is {self.count(channel, value):g}" for value in (zero, full))
        return f"{channel.name}: {low}, {high}"

    def _line(self, channel: Channel | Sensor) -> tuple[float, float]:
        """The value at number 0, and numbers for a unit."""
        if isinstance(channel, Sensor) and self.reads_amperes:
            return 0.0, 1e-3 if channel.unit == "mA" else 1.0
        if not self.full:
            return 0.0, 1.0
        zero = self.zero_ma if channel.unit == "mA" and channel.full_scale > self.zero_ma else 0.0
        full = channel.counts if channel.counts and self.step == 1.0 else self.full
        return zero, full / (channel.full_scale - zero)


IN_OWN_UNIT = Counting()
"""Volts or mA as they are."""


def analog_channels(steps: Iterable[Step]) -> tuple[Channel | Sensor, ...]:
    """Analog outputs and inputs in use, in the order of first use."""
    used: dict[Channel | Sensor, None] = {}
    for step in steps:
        match step:
            case Switch(channel=channel) if channel.kind == "analog":
                used[channel] = None
            case Line():
                used |= {event.channel: None for event in step.events if event.channel.kind == "analog"}
            case Repeat(sensor=Sensor() as sensor):
                used[sensor] = None
            case _:
                pass
    return tuple(used)


def find_out_of_range(steps: Iterable[Step], counting: Counting) -> tuple[Finding, ...]:
    """Find values beyond the range of their channel: each quantity once, with its volts and the channel."""
    found: dict[str, Finding] = {}
    for step in steps:
        for message in _out_of_range(step, counting):
            found.setdefault(message, Finding(ANALOG_OUT_OF_RANGE, message, step.made_by))
    return tuple(found.values())


def _out_of_range(step: Step, counting: Counting) -> Iterator[str]:
    match step:
        case Switch(channel=channel) if channel.kind == "analog" and not _holds(channel, step.value, counting):
            quantity = f"{step.what or channel.name} is {_place(channel, step.value, counting)}"
            yield f"{quantity}; change the value, or scale and offset in the cell's io."
        case Repeat(sensor=Sensor() as sensor) if sensor.scale:
            reading = (step.least - sensor.offset) / sensor.scale
            if not _holds(sensor, reading, counting):
                quantity = f"{step.key} >= {step.least:g} is {_place(sensor, reading, counting)}"
                yield f"{quantity}: it would not be seen; change the until, or scale and offset in the cell's io."
        case _:
            pass


def _holds(channel: Channel | Sensor, value: float, counting: Counting) -> bool:
    slack = _SLACK * channel.full_scale
    return counting.lowest(channel) - slack <= value <= channel.full_scale + slack


def _place(channel: Channel | Sensor, value: float, counting: Counting) -> str:
    kind = "output" if isinstance(channel, Channel) else "input"
    limits = f"goes from {counting.lowest(channel):g} to {channel.full_scale:g} {channel.unit}"
    return f"{value:g} {channel.unit} on {channel.name} (analog {kind} {channel.number}), which {limits}"
