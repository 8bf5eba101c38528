"""``radio-stick``: a USB radio of 50 x 23 mm, 138 mostly small parts on both sides, whose file states the pads."""

from sample_boards.assemble import Place, Sample, row
from sample_boards.shapes import rectangle, rounded

_SUPPLY = (
    Place("J1", "USB_Micro-B_Horizontal", 2.3, 11.5, 270.0),
    Place("D1", "SOT-23", 8.2, 11.5, 180.0, "ESD"),
    Place("L1", "L_0603_1608Metric", 7.9, 8.6, 0.0, "600R"),
    Place("U2", "SOT-23-5", 8.6, 5.0, 0.0, "LDO"),
    *row(Place("C1", "C_0603_1608Metric", 11.2, 4.0, 90.0, "1u"), 2, (0.0, 2.1)),
    Place("C3", "CP_EIA-3216-18_Kemet-A", 14.5, 4.5, 90.0, "10u"),
    *row(Place("R1", "R_0402_1005Metric", 11.0, 11.0, 0.0, "22R"), 2, (0.0, 1.0)),
    Place("LED1", "LED_0805_2012Metric", 4.0, 20.3),
    Place("R3", "R_0402_1005Metric", 6.3, 20.3, 0.0, "1k"),
    Place("Q1", "SOT-23", 7.6, 17.3, 0.0, "2N7002"),
)

_PROCESSOR = (
    Place("U1", "LQFP-48_7x7mm_P0.5mm", 23.8, 11.5, 0.0, "RADIO"),
    *row(Place("C4", "C_0402_1005Metric", 20.8, 16.9, 90.0, "100n"), 5, (1.5, 0.0)),
    *row(Place("C9", "C_0402_1005Metric", 20.8, 6.1, 90.0, "100n"), 5, (1.5, 0.0)),
    Place("Y1", "Crystal_SMD_3225-4Pin_3.2x2.5mm", 16.4, 11.5, 90.0, "26M"),
    *row(Place("C14", "C_0402_1005Metric", 16.4, 9.0, 0.0, "12p"), 2, (0.0, 5.0)),
    *row(Place("R4", "R_0402_1005Metric", 11.4, 16.2, 0.0, "10k"), 4, (0.0, 1.0)),
    *row(Place("R8", "R_0402_1005Metric", 13.8, 17.4, 90.0, "33R"), 6, (0.9, 0.0)),
)

# From the processor's right side to the feed of a printed antenna, whose end of the board stays bare.
_RADIO = (
    Place("U3", "QFN-16-1EP_3x3mm_P0.5mm", 34.8, 11.5, 0.0, "AMPLIFIER"),
    *row(Place("C16", "C_0201_0603Metric", 31.3, 13.65, 0.0, "100p"), 6, (1.4, 0.0)),
    *row(Place("L2", "L_0201_0603Metric", 31.3, 14.3, 0.0, "3n3"), 6, (1.4, 0.0)),
    *row(Place("C22", "C_0201_0603Metric", 31.3, 14.95, 0.0, "1p5"), 6, (1.4, 0.0)),
    *row(Place("C28", "C_0201_0603Metric", 31.3, 9.35, 0.0, "100p"), 6, (1.4, 0.0)),
    *row(Place("R14", "R_0201_0603Metric", 31.3, 8.7, 0.0, "51R"), 6, (1.4, 0.0)),
    *row(Place("L8", "L_0201_0603Metric", 31.3, 8.05, 0.0, "2n2"), 6, (1.4, 0.0)),
    *row(Place("C34", "C_0201_0603Metric", 37.6, 10.8, 0.0, "1p"), 3, (0.0, 0.7)),
    *row(Place("L14", "L_0201_0603Metric", 39.1, 11.5, 90.0, "1n8"), 3, (0.7, 0.0)),
)

_UNDER_SUPPLY = (
    Place("U4", "SOIC-8_3.9x4.9mm_P1.27mm", 8.2, 16.8, 90.0, "FLASH", "bottom"),
    Place("U5", "TSSOP-16_4.4x5mm_P0.65mm", 7.0, 6.5, 0.0, "UART", "bottom"),
    Place("U6", "SOT-23-5", 15.0, 17.5, 0.0, "LDO", "bottom"),
    *row(Place("C37", "C_0805_2012Metric", 18.2, 17.5, 90.0, "4u7", "bottom"), 2, (1.8, 0.0)),
    *row(Place("Q2", "SOT-23", 14.0, 5.0, 0.0, "BC817", "bottom"), 2, (3.2, 0.0)),
    *row(Place("C39", "C_0603_1608Metric", 14.0, 9.2, 0.0, "1u", "bottom"), 4, (0.0, 1.5)),
    *row(Place("R20", "R_0402_1005Metric", 8.0, 11.0, 90.0, "10k", "bottom"), 4, (1.1, 0.0)),
)

_UNDER_PROCESSOR = (
    *row(Place("C43", "C_0402_1005Metric", 20.8, 9.0, 0.0, "100n", "bottom"), 4, (2.0, 0.0)),
    *row(Place("C47", "C_0402_1005Metric", 20.8, 11.5, 0.0, "100n", "bottom"), 4, (2.0, 0.0)),
    *row(Place("C51", "C_0402_1005Metric", 20.8, 14.0, 0.0, "10n", "bottom"), 4, (2.0, 0.0)),
    *row(Place("R24", "R_0402_1005Metric", 21.0, 4.8, 90.0, "33R", "bottom"), 8, (0.9, 0.0)),
)

_UNDER_RADIO = (
    *row(Place("C55", "C_0201_0603Metric", 31.3, 8.7, 0.0, "10p", "bottom"), 6, (1.4, 0.0)),
    *row(Place("C61", "C_0201_0603Metric", 31.3, 9.35, 0.0, "10p", "bottom"), 6, (1.4, 0.0)),
    *row(Place("R32", "R_0201_0603Metric", 31.3, 13.65, 0.0, "0R", "bottom"), 6, (1.4, 0.0)),
    *row(Place("C67", "C_0201_0603Metric", 31.3, 14.3, 0.0, "1n", "bottom"), 6, (1.4, 0.0)),
)

RADIO_STICK = Sample(
    name="radio-stick",
    outline=rounded(rectangle((50.0, 23.0), (25.0, 11.5)), 1.0),
    holes=(),
    bottom=-1.0,
    top=0.0,
    places=(*_SUPPLY, *_PROCESSOR, *_RADIO, *_UNDER_SUPPLY, *_UNDER_PROCESSOR, *_UNDER_RADIO),
    states_pads=True,
)
