"""``sensor-hub``: an 80-part mixed-signal board of 70 x 50 mm whose file states the pads, as one from KiCad would."""

from sample_boards.assemble import Place, Sample, row
from sample_boards.shapes import circle, rectangle, rounded

_CONNECTORS = (
    Place("J1", "USB_Micro-B_Horizontal", 33.0, 2.1),
    Place("J2", "PinHeader_2x05_P2.54mm_Vertical", 5.0, 25.0, 90.0),
    Place("J3", "PinHeader_1x06_P2.54mm_Vertical", 66.5, 25.0, 90.0),
    Place("SW1", "SW_PUSH_6mm_SMD", 57.0, 6.0),
    *row(Place("LED1", "LED_0805_2012Metric", 63.5, 12.5, 90.0), 2, (3.0, 0.0)),
    *row(Place("R1", "R_0603_1608Metric", 63.5, 16.0, 90.0, "470R"), 2, (3.0, 0.0)),
)

_POWER = (
    Place("U7", "SOT-223", 44.5, 7.5, 90.0, "AMS1117-3.3"),
    Place("C1", "CP_Elec_6.3x7.7", 12.0, 7.0, 0.0, "100u"),
    Place("L1", "L_6.3x6.3_H3", 22.0, 7.5, 0.0, "10u"),
    Place("D1", "D_SMA", 22.0, 13.5, 0.0, "SS34"),
    Place("D2", "D_MiniMELF", 13.0, 13.0, 0.0, "LL4148"),
    Place("C2", "CP_EIA-3216-18_Kemet-A", 50.0, 13.5, 0.0, "10u"),
    *row(Place("C3", "C_1206_3216Metric", 40.0, 13.5, 90.0, "10u"), 3, (2.4, 0.0)),
    *row(Place("C6", "C_0805_2012Metric", 29.0, 10.5, 90.0, "1u"), 3, (2.2, 0.0)),
    *row(Place("R3", "R_0805_2012Metric", 28.5, 14.5, 0.0, "4k7"), 2, (3.4, 0.0)),
)

_PROCESSOR = (
    Place("U1", "LQFP-64_10x10mm_P0.5mm", 25.0, 26.5, 0.0, "MCU"),
    *row(Place("C9", "C_0402_1005Metric", 21.5, 34.3, 90.0, "100n"), 6, (1.3, 0.0)),
    *row(Place("C15", "C_0402_1005Metric", 21.5, 18.6, 90.0, "100n"), 6, (1.3, 0.0)),
    Place("Y1", "Crystal_SMD_3225-4Pin_3.2x2.5mm", 34.0, 20.0, 90.0, "16M"),
    *row(Place("C21", "C_0402_1005Metric", 34.0, 17.4, 0.0, "12p"), 2, (0.0, 5.2)),
    Place("U2", "BGA-144_13x13mm_P1.0mm", 45.0, 27.5, 0.0, "FPGA"),
    *row(Place("C23", "C_0402_1005Metric", 40.5, 36.0, 90.0, "100n"), 7, (1.5, 0.0)),
    *row(Place("C30", "C_0402_1005Metric", 53.6, 23.0, 0.0, "100n"), 4, (0.0, 1.4)),
    *row(Place("C34", "C_0603_1608Metric", 53.8, 29.5, 0.0, "1u"), 3, (0.0, 1.8)),
    *row(Place("R5", "R_0402_1005Metric", 34.0, 25.0, 0.0, "33R"), 5, (0.0, 1.0)),
)

_ANALOGUE = (
    Place("U3", "QFN-48-1EP_7x7mm_P0.5mm", 15.0, 41.0, 0.0, "PHY"),
    *row(Place("R10", "R_0402_1005Metric", 20.3, 39.0, 0.0, "49R9"), 4, (0.0, 1.3)),
    Place("U4", "QFN-16-1EP_3x3mm_P0.5mm", 59.0, 40.0, 45.0, "IMU"),
    Place("C37", "C_0603_1608Metric", 62.5, 42.5, 45.0, "100n"),
    Place("C38", "C_0603_1608Metric", 55.5, 42.5, 135.0, "100n"),
    Place("U5", "SOIC-8_3.9x4.9mm_P1.27mm", 28.0, 42.0, 0.0, "EEPROM"),
    Place("U6", "TSSOP-20_4.4x6.5mm_P0.65mm", 40.0, 43.0, 90.0, "ADC"),
    Place("U8", "SOT-23-5", 60.0, 31.0, 0.0, "LDO"),
    *row(Place("Q1", "SOT-23", 48.5, 41.0, 0.0, "BC817"), 2, (0.0, 4.0)),
    *row(Place("R14", "R_0805_2012Metric", 60.0, 20.0, 0.0, "10k"), 3, (0.0, 2.5)),
    *row(Place("R17", "R_0603_1608Metric", 33.3, 39.5, 90.0, "1k"), 2, (0.0, 3.0)),
    *row(Place("C39", "C_0603_1608Metric", 11.0, 18.0, 0.0, "10n"), 4, (0.0, 2.6)),
)

SENSOR_HUB = Sample(
    name="sensor-hub",
    outline=rounded(rectangle((70.0, 50.0), (35.0, 25.0)), 2.0),
    holes=tuple(circle(1.6, 16, centre) for centre in ((3.8, 3.8), (66.2, 3.8), (3.8, 46.2), (66.2, 46.2))),
    bottom=-1.6,
    top=0.0,
    places=(*_CONNECTORS, *_POWER, *_PROCESSOR, *_ANALOGUE),
    states_pads=True,
)
