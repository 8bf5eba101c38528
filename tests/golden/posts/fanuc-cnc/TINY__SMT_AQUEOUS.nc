%
<TINY__SMT_AQUEOUS>
(FANUC CNC G-code [30i, G43.4], written by Washboard)
(Board  tiny  sha256 9f2c)
(Recipe smt-aqueous  sha256 77b0)
(Cell   bench  robot gantry)
(Planned time 3.6 s, each loop once)
(Predicted time 3.7 s by this controller's model, 1.02 x planned)
(Worst event error 0.00 mm, 0.0 ms at predicted speeds)
(Worst event error 0.00 mm, 0.0 ms at planned speeds)
(Controller class 3, cycle 8 ms is in the error)
(Analog aoPressure: 0 V is 0, 10 V is 10)
(Analog aiResistivity: 0 V is 0, 10 V is 10)
(Waits for part present [30 s], door closed [12.5 s], pressure at least 3 bar [20 s])
(Does not wait for temperature: the cell maps no such input)
(Stops, valves shut, without door closed: to be wired)
(Parts: 1 clean, 2 clean, 3 clean)
(To finish a stopped board from part 2 to 3: write its number into the block #100=1, its way from home was not checked)
(Outputs left as they are at the end: aoPressure, goMedium)
(Shared with other programs of this cell: macro O7991, variables, G54 and up are set at each start)
(Set up: parameters: G43.4 alone moves nothing [TOS], G0 interpolates [LRP], G5.1 keeps within 0.05 mm)
(Set up: M codes of outputs: finished at once [high-speed interface], not buffered where they stand alone)
(Set up: O7991: your macro, sets output A to value V, the PMC copies analog inputs to #600 and up)
(Set up: PMC: shut the valves at reset, alarm and emergency stop, as TINY__SMT_AQUEOUS_SH does)
(Set up: PMC: feed hold, valves shut, when an input leaves its state)
(Axes: X = X [mm], Y = Y [mm], Z = Z [mm], C = C [deg], B = B [deg])
(Tool points: 180 mm from the axis of B to the orifice, with every tool)
(Machine zero: X Y Z of the cell's joints where B is 0, the tool's length is beyond it)
(F: mm/min of the orifice, deg/min where only B and C turn. B and C count on beyond a turn: no roll-over)
(C counts as the cell's joint, plus 90 deg, B tilts to +X at C0)
(B counts against the cell's joint, B tilts to +X at C0)
(On the spot, and with the jet off, B and C go evenly, as the check found clear)
(Output aoPressure: A101 of macro O7991, 2 * pressure_bar + 0.5 in V)
(Output doWash: M203 on, M202 off, opens ring60)
(Output doAir: M205 on, M204 off, opens knife)
(Output goMedium: A201 of macro O7991, 1 for saponifier-15, 2 for di-water, 3 for hot-air)
(Input diPart: #1003, part present when on)
(Input diDoor: #1004, door closed when off, watched)
(Input aiPressure: #602, pressure, supply_bar = 1.25 * reading - 2.5)
(Input aiResistivity: #601, ends loops, resistivity_mohm_cm = 2 * reading)
(the part to start at, 1 is the whole program of 3)
#100=1
G21 G90 G17 G40 G49 G80 G94
(G54: origin of the board, leave this block out after touching off)
G10 L2 P1 X410 Y-120.5 Z15.25 C0 B0
#3004=2
M98 <TINY__SMT_AQUEOUS_SH>
#3001=0
N301
IF[#1003EQ1]GOTO401
IF[#3001LT30000]GOTO301
#3000=1(no part present)
N401
#3001=0
N302
IF[#1004EQ0]GOTO402
IF[#3001LT12500]GOTO302
#3000=2(close the door)
N402
#3001=0
N303
IF[[1.25*#602]+[-2.5]GE3]GOTO403
IF[#3001LT20000]GOTO303
#3000=3(no pressure)
N403
G49
G5.1 Q0
G53 G0 Z300.0000
G49
G5.1 Q0
G53 G0 X0.0000 Y-50.0000 Z300.0000 C118.6479 B0.0000
IF[#100GT1]GOTO201
M98 <TINY__SMT_AQUEOUS_01>
N201
(until resistivity_mohm_cm >= 1, 4 times at most)
#111=0
N501
#111=#111+1
IF[#100GT2]GOTO202
M98 <TINY__SMT_AQUEOUS_02>
N202
IF[[#111LT4]AND[[[2*#601]+0]LT1]]GOTO501
IF[#100GT3]GOTO203
M98 <TINY__SMT_AQUEOUS_03>
N203
G49
G5.1 Q0
G53 G0 X0.0000 Y-50.0000 Z300.0000 C118.6479 B0.0000
#3004=0
M30
<TINY__SMT_AQUEOUS_SH>
M202
M204
M99
<TINY__SMT_AQUEOUS_01>
M202
M204
G54
(function clean)
(nozzle ring60, tool 1)
G49
G5.1 Q0
T1 M6
(solution saponifier-15)
G65 P7991 A201 V1
(pressure_bar = 3.500)
G65 P7991 A101 V7.5
(s/transfer)
G5.1 Q1
G43.4 H1
G0 X0.0000 Y0.0000 Z110.0000 C0.0000 B0.0000
G61 G1 Z50.0000 F5667.4
M99
<TINY__SMT_AQUEOUS_02>
G54
IF[#100NE2]GOTO92
#100=1
G49
G5.1 Q0
T1 M6
G65 P7991 A201 V1
G65 P7991 A101 V7.5
G5.1 Q1
G43.4 H1
G0 X0.0000 Y0.0000 Z110.0000 C0.0000 B0.0000
G61 G1 Z50.0000 F5667.4
N92
M203
(s/pass)
G4 X0.040
G5.1 Q1
G43.4 H1
G61 G1 X34.6410 Y20.0000 Z50.0000 C0.0000 B0.0000 F3348.4
M202
G4 X0.020
(s/transfer)
G1 X29.6410 Y28.6603 F2471.7
M203
(s/pass)
G4 X0.040
G1 X-5.0000 Y8.6603 F3348.4
M202
G4 X0.020
(s/transfer)
G1 X0.0000 Y0.0000 F2471.7
M99
<TINY__SMT_AQUEOUS_03>
G54
IF[#100NE3]GOTO93
#100=1
G49
G5.1 Q0
T1 M6
G65 P7991 A201 V1
G65 P7991 A101 V7.5
G5.1 Q1
G43.4 H1
G0 X0.0000 Y0.0000 Z110.0000 C0.0000 B0.0000
G61 G1 Z50.0000 F5667.4
G1 X34.6410 Y20.0000 F3348.4
G1 X29.6410 Y28.6603 F2471.7
G1 X-5.0000 Y8.6603 F3348.4
G1 X0.0000 Y0.0000 F2471.7
N93
(s/transfer)
G5.1 Q1
G43.4 H1
G61 G1 X0.0000 Y0.0000 Z110.0000 C0.0000 B0.0000 F5667.4
M99
%
