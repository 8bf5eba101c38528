0 BEGIN PGM TINY MM
1 ; HEIDENHAIN Klartext (TNC, TCPM), written by Washboard
2 ; Board  tiny  sha256 9f2c
3 ; Recipe smt-aqueous  sha256 77b0
4 ; Cell   bench  robot gantry
5 ; Planned time 3.6 s, each loop once
6 ; Predicted time 3.0 s by this controller's model, 0.82 x planned
7 ; Worst event error 0.00 mm, 0.0 ms at predicted speeds
8 ; Worst event error 0.00 mm, 0.0 ms at planned speeds
9 ; Controller class 3; cycle 10 ms is in the error
10 ; Analog aoPressure: 0 V is 0, 10 V is 10
11 ; Analog aiResistivity: 0 V is 0, 10 V is 10
12 ; Waits for part present (30 s), door closed (12.5 s), pressure at least 3 bar (20 s)
13 ; Does not wait for temperature: the cell maps no such input
14 ; Stops, valves shut, without door closed: to be wired, see below
15 ; Parts: 1 clean, 2 clean, 3 clean
16 ; To finish a stopped board from part 2 to 3: write its number into the block Q50 = +1; its way from home was not checked
17 ; Set up: active preset: zero of the machine; CYCL DEF 7 shifts it to the board. Cycle 32 lets corners be passed
18 ; Set up: PLC: M functions of outputs act where their block begins; FN 19 sends an output's number and its value
19 ; Set up: PLC: errors of FN 14 with your texts; valves shut at stop, cancel and emergency stop; override at 100
20 ; Set up: PLC: NC stop, valves shut, when diDoor leaves its state: door closed
21 ; Output aoPressure: FN 19 with 101
22 ; Output doWash: M403 on, M402 off
23 ; Output goMedium: FN 19 with 201
24 ; Input diPart: I3 of the PLC, part present
25 ; Input diDoor: I4 of the PLC, door closed
26 ; Input aiPressure: W2 of the PLC, pressure
27 ; Axes: X = X (mm), Y = Y (mm), Z = Z (mm), C = C (deg), B = B (deg)
28 ; Tool points: 180 mm from the axis of B to the orifice, with every tool
29 ; Machine zero: X Y Z of the cell's joints where B is 0; the tool's length is beyond it
30 ; F: mm/min of the orifice, deg/min where only B and C turn. B and C count on beyond a turn: no roll-over
31 ; C counts as the cell's joint, plus 90 deg; B tilts to +X at C0
32 ; B counts against the cell's joint; B tilts to +X at C0
33 ; On the spot, and with the jet off, B and C go evenly, as the check found clear
34 ; the part to start at; 1 is the whole program of 3
35 Q50 = +1
36 CYCL DEF 32.0 TOLERANCE
37 CYCL DEF 32.1 T0.05
38 CYCL DEF 32.2 HSC-MODE:0 TA0.25
39 CALL LBL "shut_valves"
40 Q60 = +0
41 LBL 301
42 CYCL DEF 9.0 DWELL TIME
43 CYCL DEF 9.1 DWELL 0.1
44 Q60 = Q60 + 1
45 FN 18: SYSREAD Q61 = ID2000 NR20 IDX3
46 FN 9: IF +Q61 EQU +1 GOTO LBL 401
47 FN 12: IF +Q60 LT +300 GOTO LBL 301
48 FN 14: ERROR=301 ; no part present
49 LBL 401
50 Q60 = +0
51 LBL 302
52 CYCL DEF 9.0 DWELL TIME
53 CYCL DEF 9.1 DWELL 0.1
54 Q60 = Q60 + 1
55 FN 18: SYSREAD Q61 = ID2000 NR20 IDX4
56 FN 9: IF +Q61 EQU +0 GOTO LBL 402
57 FN 12: IF +Q60 LT +125 GOTO LBL 302
58 FN 14: ERROR=302 ; close the door
59 LBL 402
60 Q60 = +0
61 LBL 303
62 CYCL DEF 9.0 DWELL TIME
63 CYCL DEF 9.1 DWELL 0.1
64 Q60 = Q60 + 1
65 FN 18: SYSREAD Q61 = ID2000 NR70 IDX2
66 Q61 = +1.25 * Q61 + -2.5
67 FN 9: IF +Q61 EQU +3 GOTO LBL 403
68 FN 11: IF +Q61 GT +3 GOTO LBL 403
69 FN 12: IF +Q60 LT +200 GOTO LBL 303
70 FN 14: ERROR=303 ; no pressure
71 LBL 403
72 FUNCTION RESET TCPM
73 L Z+300.0000 R0 FMAX M91
74 FUNCTION RESET TCPM
75 L X+0.0000 Y-50.0000 Z+300.0000 C+118.6479 B+0.0000 R0 FMAX M91
76 FN 11: IF +Q50 GT +1 GOTO LBL 201
77 CALL LBL "CLEAN_01"
78 LBL 201
79 ; until resistivity_mohm_cm >= 1, 4 times at most
80 Q71 = +0
81 LBL 501
82 Q71 = Q71 + 1
83 FN 11: IF +Q50 GT +2 GOTO LBL 202
84 CALL LBL "CLEAN_02"
85 LBL 202
86 FN 20: WAIT FOR SYNC
87 FN 18: SYSREAD Q61 = ID2000 NR70 IDX1
88 Q61 = +2 * Q61 + +0
89 FN 9: IF +Q61 EQU +1 GOTO LBL 601
90 FN 11: IF +Q61 GT +1 GOTO LBL 601
91 FN 12: IF +Q71 LT +4 GOTO LBL 501
92 LBL 601
93 FN 11: IF +Q50 GT +3 GOTO LBL 203
94 CALL LBL "CLEAN_03"
95 LBL 203
96 FUNCTION RESET TCPM
97 L X+0.0000 Y-50.0000 Z+300.0000 C+118.6479 B+0.0000 R0 FMAX M91
98 M30
99 LBL "shut_valves"
100 M402
101 LBL 0
102 LBL "CLEAN_01"
103 M402
104 CYCL DEF 7.0 DATUM SHIFT
105 CYCL DEF 7.1 X+410
106 CYCL DEF 7.2 Y-120.5
107 CYCL DEF 7.3 Z+15.25
108 ; function clean
109 ; nozzle ring60, tool 1
110 FUNCTION RESET TCPM
111 TOOL CALL 1 Z
112 ; solution saponifier-15
113 FN 19: PLC=+201/+1
114 ; pressure_bar = 3.500
115 FN 19: PLC=+101/+7.5
116 ; s/transfer
117 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
118 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 R0 FMAX
119 L Z+50.0000 F9780
120 FN 20: WAIT FOR SYNC
121 LBL 0
122 LBL "CLEAN_02"
123 CYCL DEF 7.0 DATUM SHIFT
124 CYCL DEF 7.1 X+410
125 CYCL DEF 7.2 Y-120.5
126 CYCL DEF 7.3 Z+15.25
127 FN 10: IF +Q50 NE +2 GOTO LBL 92
128 Q50 = +1
129 FUNCTION RESET TCPM
130 TOOL CALL 1 Z
131 FN 19: PLC=+201/+1
132 FN 19: PLC=+101/+7.5
133 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
134 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 R0 FMAX
135 L Z+50.0000 F9780
136 FN 20: WAIT FOR SYNC
137 LBL 92
138 M403
139 ; s/pass
140 CYCL DEF 9.0 DWELL TIME
141 CYCL DEF 9.1 DWELL 0.040
142 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
143 L X+34.6410 Y+20.0000 Z+50.0000 C+0.0000 B+0.0000 F3599.5
144 FN 20: WAIT FOR SYNC
145 M402
146 CYCL DEF 9.0 DWELL TIME
147 CYCL DEF 9.1 DWELL 0.020
148 ; s/transfer
149 L X+29.6410 Y+28.6603 F3819.2
150 FN 20: WAIT FOR SYNC
151 M403
152 ; s/pass
153 CYCL DEF 9.0 DWELL TIME
154 CYCL DEF 9.1 DWELL 0.040
155 L X-5.0000 Y+8.6603 F3599.5
156 FN 20: WAIT FOR SYNC
157 M402
158 CYCL DEF 9.0 DWELL TIME
159 CYCL DEF 9.1 DWELL 0.020
160 ; s/transfer
161 L X+0.0000 Y+0.0000 F3819.2
162 FN 20: WAIT FOR SYNC
163 LBL 0
164 LBL "CLEAN_03"
165 CYCL DEF 7.0 DATUM SHIFT
166 CYCL DEF 7.1 X+410
167 CYCL DEF 7.2 Y-120.5
168 CYCL DEF 7.3 Z+15.25
169 FN 10: IF +Q50 NE +3 GOTO LBL 93
170 Q50 = +1
171 FUNCTION RESET TCPM
172 TOOL CALL 1 Z
173 FN 19: PLC=+201/+1
174 FN 19: PLC=+101/+7.5
175 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
176 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 R0 FMAX
177 L Z+50.0000 F9780
178 FN 20: WAIT FOR SYNC
179 L X+34.6410 Y+20.0000 F3599.5
180 FN 20: WAIT FOR SYNC
181 L X+29.6410 Y+28.6603 F3819.2
182 FN 20: WAIT FOR SYNC
183 L X-5.0000 Y+8.6603 F3599.5
184 FN 20: WAIT FOR SYNC
185 L X+0.0000 Y+0.0000 F3819.2
186 FN 20: WAIT FOR SYNC
187 LBL 93
188 ; s/transfer
189 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
190 L X+0.0000 Y+0.0000 Z+110.0000 C+0.0000 B+0.0000 F9780
191 FN 20: WAIT FOR SYNC
192 LBL 0
193 END PGM TINY MM
