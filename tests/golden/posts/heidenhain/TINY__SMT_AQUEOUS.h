0 BEGIN PGM TINY__SMT_AQUEOUS MM
1 ; HEIDENHAIN Klartext (TNC, TCPM), written by Washboard
2 ; Board  tiny  sha256 9f2c
3 ; Recipe smt-aqueous  sha256 77b0
4 ; Cell   bench  robot gantry
5 ; Planned time 3.6 s, each loop once
6 ; Predicted time 3.7 s by this controller's model, 1.02 x planned
7 ; Worst event error 0.00 mm, 0.0 ms at predicted speeds
8 ; Worst event error 0.00 mm, 0.0 ms at planned speeds
9 ; Controller class 3; cycle 10 ms is in the error
10 ; Analog aoPressure: 0 V is 0, 10 V is 10
11 ; Analog aiResistivity: 0 V is 0, 10 V is 10
12 ; Waits for part present (30 s), door closed (12.5 s), pressure at least 3 bar (20 s)
13 ; Does not wait for temperature: the cell maps no such input
14 ; Stops, valves shut, without door closed: to be wired
15 ; Parts: 1 clean, 2 clean, 3 clean
16 ; To finish a stopped board from part 2 to 3: write its number into the block Q50 = +1; its way from home was not checked
17 ; Outputs left as they are at the end: aoPressure, goMedium
18 ; Shared with other programs of this cell: Q50 and up, set at each start
19 ; Set up: PLC: M functions of outputs act where their block begins; FN 19 sends an output's number and its value
20 ; Set up: PLC: errors of FN 14 with your texts
21 ; Set up: PLC: valves shut at stop, cancel and emergency stop; override at 100
22 ; Set up: PLC: NC stop, valves shut, when an input leaves its state
23 ; Active preset: zero of the machine; CYCL DEF 7 shifts it to the board. Cycle 32 lets corners be passed
24 ; Axes: X = X (mm), Y = Y (mm), Z = Z (mm), C = C (deg), B = B (deg)
25 ; Tool points: 180 mm from the axis of B to the orifice, with every tool
26 ; Machine zero: X Y Z of the cell's joints where B is 0; the tool's length is beyond it
27 ; F: mm/min of the orifice, deg/min where only B and C turn. B and C count on beyond a turn: no roll-over
28 ; C counts as the cell's joint, plus 90 deg; B tilts to +X at C0
29 ; B counts against the cell's joint; B tilts to +X at C0
30 ; On the spot, and with the jet off, B and C go evenly, as the check found clear
31 ; Output aoPressure: FN 19 with 101, 2 * pressure_bar + 0.5 in V
32 ; Output doWash: M403 on, M402 off, opens ring60
33 ; Output doAir: M405 on, M404 off, opens knife
34 ; Output goMedium: FN 19 with 201, 1 for saponifier-15, 2 for di-water, 3 for hot-air
35 ; Input diPart: I3 of the PLC, part present when on
36 ; Input diDoor: I4 of the PLC, door closed when off, watched
37 ; Input aiPressure: W2 of the PLC, pressure, supply_bar = 1.25 * reading - 2.5
38 ; Input aiResistivity: W1 of the PLC, ends loops, resistivity_mohm_cm = 2 * reading
39 ; the part to start at; 1 is the whole program of 3
40 Q50 = +1
41 CYCL DEF 32.0 TOLERANCE
42 CYCL DEF 32.1 T0.05
43 CYCL DEF 32.2 HSC-MODE:0 TA0.25
44 CALL LBL "shut_valves"
45 Q60 = +0
46 LBL 301
47 CYCL DEF 9.0 DWELL TIME
48 CYCL DEF 9.1 DWELL 0.1
49 Q60 = Q60 + 1
50 FN 18: SYSREAD Q61 = ID2000 NR20 IDX3
51 FN 9: IF +Q61 EQU +1 GOTO LBL 401
52 FN 12: IF +Q60 LT +300 GOTO LBL 301
53 FN 14: ERROR=301 ; no part present
54 LBL 401
55 Q60 = +0
56 LBL 302
57 CYCL DEF 9.0 DWELL TIME
58 CYCL DEF 9.1 DWELL 0.1
59 Q60 = Q60 + 1
60 FN 18: SYSREAD Q61 = ID2000 NR20 IDX4
61 FN 9: IF +Q61 EQU +0 GOTO LBL 402
62 FN 12: IF +Q60 LT +125 GOTO LBL 302
63 FN 14: ERROR=302 ; close the door
64 LBL 402
65 Q60 = +0
66 LBL 303
67 CYCL DEF 9.0 DWELL TIME
68 CYCL DEF 9.1 DWELL 0.1
69 Q60 = Q60 + 1
70 FN 18: SYSREAD Q61 = ID2000 NR70 IDX2
71 Q61 = +1.25 * Q61 + -2.5
72 FN 9: IF +Q61 EQU +3 GOTO LBL 403
73 FN 11: IF +Q61 GT +3 GOTO LBL 403
74 FN 12: IF +Q60 LT +200 GOTO LBL 303
75 FN 14: ERROR=303 ; no pressure
76 LBL 403
77 FUNCTION RESET TCPM
78 L Z+300.0000 R0 FMAX M91
79 FUNCTION RESET TCPM
80 L X+0.0000 Y-50.0000 Z+300.0000 C+118.6479 B+0.0000 R0 FMAX M91
81 FN 11: IF +Q50 GT +1 GOTO LBL 201
82 CALL LBL "CLEAN_01"
83 LBL 201
84 ; until resistivity_mohm_cm >= 1, 4 times at most
85 Q71 = +0
86 LBL 501
87 Q71 = Q71 + 1
88 FN 11: IF +Q50 GT +2 GOTO LBL 202
89 CALL LBL "CLEAN_02"
90 LBL 202
91 FN 20: WAIT FOR SYNC
92 FN 18: SYSREAD Q61 = ID2000 NR70 IDX1
93 Q61 = +2 * Q61 + +0
94 FN 9: IF +Q61 EQU +1 GOTO LBL 601
95 FN 11: IF +Q61 GT +1 GOTO LBL 601
96 FN 12: IF +Q71 LT +4 GOTO LBL 501
97 LBL 601
98 FN 11: IF +Q50 GT +3 GOTO LBL 203
99 CALL LBL "CLEAN_03"
100 LBL 203
101 FUNCTION RESET TCPM
102 L X+0.0000 Y-50.0000 Z+300.0000 C+118.6479 B+0.0000 R0 FMAX M91
103 CYCL DEF 7.0 DATUM SHIFT
104 CYCL DEF 7.1 X+0
105 CYCL DEF 7.2 Y+0
106 CYCL DEF 7.3 Z+0
107 CYCL DEF 32.0 TOLERANCE
108 CYCL DEF 32.1
109 M30
110 LBL "shut_valves"
111 M402
112 M404
113 LBL 0
114 LBL "CLEAN_01"
115 M402
116 M404
117 CYCL DEF 7.0 DATUM SHIFT
118 CYCL DEF 7.1 X+410
119 CYCL DEF 7.2 Y-120.5
120 CYCL DEF 7.3 Z+15.25
121 ; function clean
122 ; nozzle ring60, tool 1
123 FUNCTION RESET TCPM
124 TOOL CALL 1 Z
125 ; solution saponifier-15
126 FN 19: PLC=+201/+1
127 ; pressure_bar = 3.500
128 FN 19: PLC=+101/+7.5
129 ; s/transfer
130 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
131 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 R0 FMAX
132 L Z+50.0000 F5667.4
133 FN 20: WAIT FOR SYNC
134 LBL 0
135 LBL "CLEAN_02"
136 CYCL DEF 7.0 DATUM SHIFT
137 CYCL DEF 7.1 X+410
138 CYCL DEF 7.2 Y-120.5
139 CYCL DEF 7.3 Z+15.25
140 FN 10: IF +Q50 NE +2 GOTO LBL 92
141 Q50 = +1
142 FUNCTION RESET TCPM
143 TOOL CALL 1 Z
144 FN 19: PLC=+201/+1
145 FN 19: PLC=+101/+7.5
146 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
147 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 R0 FMAX
148 L Z+50.0000 F5667.4
149 FN 20: WAIT FOR SYNC
150 LBL 92
151 M403
152 ; s/pass
153 CYCL DEF 9.0 DWELL TIME
154 CYCL DEF 9.1 DWELL 0.040
155 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
156 L X+34.6410 Y+20.0000 Z+50.0000 C+0.0000 B+0.0000 F3348.4
157 FN 20: WAIT FOR SYNC
158 M402
159 CYCL DEF 9.0 DWELL TIME
160 CYCL DEF 9.1 DWELL 0.020
161 ; s/transfer
162 L X+29.6410 Y+28.6603 F2471.7
163 FN 20: WAIT FOR SYNC
164 M403
165 ; s/pass
166 CYCL DEF 9.0 DWELL TIME
167 CYCL DEF 9.1 DWELL 0.040
168 L X-5.0000 Y+8.6603 F3348.4
169 FN 20: WAIT FOR SYNC
170 M402
171 CYCL DEF 9.0 DWELL TIME
172 CYCL DEF 9.1 DWELL 0.020
173 ; s/transfer
174 L X+0.0000 Y+0.0000 F2471.7
175 FN 20: WAIT FOR SYNC
176 LBL 0
177 LBL "CLEAN_03"
178 CYCL DEF 7.0 DATUM SHIFT
179 CYCL DEF 7.1 X+410
180 CYCL DEF 7.2 Y-120.5
181 CYCL DEF 7.3 Z+15.25
182 FN 10: IF +Q50 NE +3 GOTO LBL 93
183 Q50 = +1
184 FUNCTION RESET TCPM
185 TOOL CALL 1 Z
186 FN 19: PLC=+201/+1
187 FN 19: PLC=+101/+7.5
188 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
189 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 R0 FMAX
190 L Z+50.0000 F5667.4
191 FN 20: WAIT FOR SYNC
192 L X+34.6410 Y+20.0000 F3348.4
193 FN 20: WAIT FOR SYNC
194 L X+29.6410 Y+28.6603 F2471.7
195 FN 20: WAIT FOR SYNC
196 L X-5.0000 Y+8.6603 F3348.4
197 FN 20: WAIT FOR SYNC
198 L X+0.0000 Y+0.0000 F2471.7
199 FN 20: WAIT FOR SYNC
200 LBL 93
201 ; s/transfer
202 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
203 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 F5667.4
204 FN 20: WAIT FOR SYNC
205 LBL 0
206 END PGM TINY__SMT_AQUEOUS MM
