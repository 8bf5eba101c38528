"""Every sample part by the name of its package."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

from sample_boards.connectors import pin_header, port, push_button, surface_port
from sample_boards.leaded import GullWing, dual, folded, quad, sot
from sample_boards.leadless import ball_grid, can, chip, crystal, inductor, light, melf, quad_flat
from sample_boards.shape import Shape

from boards.board import Pad

_CHIPS = {
    # length, width, height, terminal, gap under the body
    "R_0201_0603Metric": ((0.6, 0.3, 0.23), 0.15, 0.02),
    "C_0201_0603Metric": ((0.6, 0.3, 0.3), 0.15, 0.02),
    "L_0201_0603Metric": ((0.6, 0.3, 0.3), 0.15, 0.02),
    "R_0402_1005Metric": ((1.0, 0.5, 0.35), 0.25, 0.02),
    "C_0402_1005Metric": ((1.0, 0.5, 0.5), 0.25, 0.02),
    "R_0603_1608Metric": ((1.6, 0.8, 0.45), 0.3, 0.03),
    "C_0603_1608Metric": ((1.6, 0.8, 0.8), 0.35, 0.03),
    "L_0603_1608Metric": ((1.6, 0.8, 0.8), 0.3, 0.03),
    "R_0805_2012Metric": ((2.0, 1.25, 0.5), 0.4, 0.04),
    "C_0805_2012Metric": ((2.0, 1.25, 1.25), 0.5, 0.04),
    "R_1206_3216Metric": ((3.2, 1.6, 0.55), 0.5, 0.04),
    "C_1206_3216Metric": ((3.2, 1.6, 1.6), 0.5, 0.04),
    "C_1210_3225Metric": ((3.2, 2.5, 2.5), 0.5, 0.05),
}

# IPC-7351, nominal: two of 0.46 x 0.4 mm, which reach well beyond the part.
_LANDS_0201 = (Pad(-0.32, 0.0, 0.46, 0.4), Pad(0.32, 0.0, 0.46, 0.4))

# Body, span, height, standoff, pitch, (lead width, thickness, foot).
_SO_LEAD = (0.4, 0.2, 0.6)
_SOIC_8 = GullWing((3.9, 4.9), 6.0, 1.7, 0.15, 1.27, _SO_LEAD)
_SOIC_14 = GullWing((3.9, 8.7), 6.0, 1.7, 0.15, 1.27, _SO_LEAD)
_SOIC_16 = GullWing((3.9, 9.9), 6.0, 1.7, 0.15, 1.27, _SO_LEAD)
_TSSOP_16 = GullWing((4.4, 5.0), 6.4, 1.1, 0.1, 0.65, (0.24, 0.15, 0.55))
_TSSOP_20 = GullWing((4.4, 6.5), 6.4, 1.1, 0.1, 0.65, (0.24, 0.15, 0.55))
_LQFP_48 = GullWing((7.0, 7.0), 9.0, 1.5, 0.1, 0.5, (0.22, 0.15, 0.6))
_LQFP_64 = GullWing((10.0, 10.0), 12.0, 1.5, 0.1, 0.5, (0.22, 0.15, 0.6))
_LQFP_100 = GullWing((14.0, 14.0), 16.0, 1.5, 0.1, 0.5, (0.22, 0.15, 0.6))
_SOT_23 = GullWing((1.3, 2.9), 2.4, 1.05, 0.06, 0.95, (0.42, 0.12, 0.3))
_SOT_23_5 = GullWing((1.6, 2.9), 2.8, 1.2, 0.08, 0.95, (0.4, 0.12, 0.32))
_SOT_223 = GullWing((3.5, 6.5), 7.0, 1.7, 0.06, 2.3, (0.7, 0.28, 0.9))

_OTHERS: dict[str, Callable[[str], Shape]] = {
    "LED_0805_2012Metric": lambda name: light((2.0, 1.25, 0.8), name),
    "D_MiniMELF": lambda name: melf(3.5, 1.4, name),
    "D_SMA": lambda name: folded((4.9, 2.6, 2.2), (1.5, 1.0), name),
    "CP_EIA-3216-18_Kemet-A": lambda name: folded((3.2, 1.6, 1.6), (1.2, 0.7), name),
    "CP_EIA-6032-28_Kemet-C": lambda name: folded((6.0, 3.2, 2.6), (2.2, 1.2), name),
    "SOT-23": lambda name: sot(_SOT_23, (0.95, -0.95), ((0.0, 0.42),), name),
    "SOT-23-5": lambda name: sot(_SOT_23_5, (0.95, 0.0, -0.95), ((-0.95, 0.4), (0.95, 0.4)), name),
    "SOT-223": lambda name: sot(_SOT_223, (2.3, 0.0, -2.3), ((0.0, 3.0),), name),
    "SOIC-8_3.9x4.9mm_P1.27mm": lambda name: dual(_SOIC_8, 8, name),
    "SOIC-14_3.9x8.7mm_P1.27mm": lambda name: dual(_SOIC_14, 14, name),
    "SOIC-16_3.9x9.9mm_P1.27mm": lambda name: dual(_SOIC_16, 16, name),
    "TSSOP-16_4.4x5mm_P0.65mm": lambda name: dual(_TSSOP_16, 16, name),
    "TSSOP-20_4.4x6.5mm_P0.65mm": lambda name: dual(_TSSOP_20, 20, name),
    "LQFP-48_7x7mm_P0.5mm": lambda name: quad(_LQFP_48, 48, name),
    "LQFP-64_10x10mm_P0.5mm": lambda name: quad(_LQFP_64, 64, name),
    "LQFP-100_14x14mm_P0.5mm": lambda name: quad(_LQFP_100, 100, name),
    "QFN-16-1EP_3x3mm_P0.5mm": lambda name: quad_flat(3.0, 16, 0.5, 1.7, name),
    "QFN-32-1EP_5x5mm_P0.5mm": lambda name: quad_flat(5.0, 32, 0.5, 3.4, name),
    "QFN-48-1EP_7x7mm_P0.5mm": lambda name: quad_flat(7.0, 48, 0.5, 5.4, name),
    "BGA-144_13x13mm_P1.0mm": lambda name: ball_grid(13.0, 12, 1.0, name),
    "CP_Elec_6.3x7.7": lambda name: can(6.3, 7.7, name),
    "CP_Elec_8x10": lambda name: can(8.0, 10.0, name),
    "L_6.3x6.3_H3": lambda name: inductor(6.3, 3.0, name),
    "Crystal_SMD_3225-4Pin_3.2x2.5mm": lambda name: crystal(3.2, 2.5, name),
    "PinHeader_1x04_P2.54mm_Vertical": lambda _: pin_header(1, 4),
    "PinHeader_1x06_P2.54mm_Vertical": lambda _: pin_header(1, 6),
    "PinHeader_2x05_P2.54mm_Vertical": lambda _: pin_header(2, 5),
    "PinHeader_2x10_P2.54mm_Vertical": lambda _: pin_header(2, 10),
    "USB_A_Horizontal": lambda name: port((13.1, 14.2, 7.0), 0.4, _USB_PEGS, name),
    "RJ45_Magnetics_Horizontal": lambda name: port((16.0, 21.3, 16.0), 1.2, _RJ45_PEGS, name),
    "USB_Micro-B_Horizontal": lambda name: surface_port((7.5, 5.0, 2.6), 5, name),
    "SW_PUSH_6mm_SMD": lambda name: push_button(6.0, 5.0, name),
}

_USB_PEGS = ((-3.5, 4.6), (-1.0, 4.6), (1.0, 4.6), (3.5, 4.6))
_RJ45_PEGS = tuple((-4.445 + 1.27 * k, 6.0 + 2.54 * (k % 2)) for k in range(8))


@cache
def shape_of(package: str) -> Shape:
    """Make the part of that package; it raises KeyError for a name that is not in the catalogue."""
    if package in _CHIPS:
        return replace(chip(*_CHIPS[package], package), lands=_LANDS_0201 if "_0201_" in package else ())
    return _OTHERS[package](package)
