"""``two-sided``: an L-shaped board with slots and a cut-out, parts on both sides, its bottom at z = 0."""

from sample_boards.assemble import Place, Sample, row
from sample_boards.shapes import circle, rectangle, rounded, slot

_OUTLINE = ((-25.0, -18.0), (45.0, -18.0), (45.0, 12.0), (15.0, 12.0), (15.0, 37.0), (-25.0, 37.0))

_TOP = (
    Place("J1", "USB_Micro-B_Horizontal", 36.0, -15.9),
    Place("J2", "PinHeader_2x05_P2.54mm_Vertical", -21.5, 14.0, 90.0),
    Place("U1", "LQFP-64_10x10mm_P0.5mm", -6.0, 23.0, 0.0, "MCU"),
    Place("U2", "SOIC-16_3.9x9.9mm_P1.27mm", 27.0, -2.0, 0.0, "ISOLATOR"),
    Place("U3", "QFN-32-1EP_5x5mm_P0.5mm", -6.0, -3.0, 45.0, "SENSOR"),
    Place("U4", "SOT-223", 8.0, -12.0, 0.0, "REGULATOR"),
    Place("C1", "CP_Elec_6.3x7.7", -17.0, -8.5, 90.0, "100u"),
    Place("L1", "L_6.3x6.3_H3", 19.0, -12.0, 0.0, "22u"),
    *row(Place("C2", "C_0402_1005Metric", -9.0, 30.5, 90.0, "100n"), 6, (1.2, 0.0)),
    *row(Place("C8", "C_0603_1608Metric", 4.0, 18.0, 0.0, "1u"), 4, (0.0, 1.8)),
    *row(Place("R1", "R_0805_2012Metric", 36.0, -6.5, 0.0, "4k7"), 4, (0.0, 2.5)),
    Place("LED1", "LED_0805_2012Metric", 42.0, 5.0, 90.0),
    Place("D1", "D_SMA", 27.5, -12.0, 90.0, "SS34"),
)

_BOTTOM = (
    Place("U5", "QFN-16-1EP_3x3mm_P0.5mm", -6.0, 23.0, 0.0, "CHARGER", "bottom"),
    Place("U6", "SOIC-8_3.9x4.9mm_P1.27mm", 6.0, -9.0, 90.0, "FLASH", "bottom"),
    Place("D2", "D_MiniMELF", -4.0, -9.0, 0.0, "LL4148", "bottom"),
    Place("U7", "TSSOP-16_4.4x5mm_P0.65mm", 38.5, -2.0, 0.0, "MUX", "bottom"),
    Place("Y1", "Crystal_SMD_3225-4Pin_3.2x2.5mm", -6.0, 31.0, 0.0, "16M", "bottom"),
    *row(Place("C12", "C_0402_1005Metric", -8.7, 20.75, 0.0, "100n", "bottom"), 6, (0.0, 0.9)),
    *row(Place("Q1", "SOT-23", 18.0, -12.0, 90.0, "2N7002", "bottom"), 2, (4.5, 0.0)),
    Place("C18", "CP_EIA-3216-18_Kemet-A", -18.0, -8.0, 30.0, "10u", "bottom"),
    *row(Place("R5", "R_0603_1608Metric", 2.0, 23.0, 90.0, "10k", "bottom"), 5, (1.5, 0.0)),
)

_ROUND = tuple(circle(1.35, 16, centre) for centre in ((-21.5, 33.5), (11.5, 33.5), (41.5, 8.5), (-21.5, -14.5)))
_SLOTS = (slot(24.0, 2.0, (6.0, 8.0)), tuple((y + 20.5, x) for x, y in slot(12.0, 2.0, (-2.0, 0.0))))
_CUT_OUT = rounded(rectangle((7.0, 5.0), (-12.0, 9.0)), 1.0, 3)

TWO_SIDED = Sample(
    name="two-sided",
    outline=rounded(_OUTLINE, 3.0),
    holes=(*_ROUND, *_SLOTS, _CUT_OUT),
    bottom=0.0,
    top=1.6,
    places=(*_TOP, *_BOTTOM),
)
