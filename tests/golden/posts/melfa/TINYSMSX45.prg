1 ' Mitsubishi MELFA-BASIC, written by Washboard
2 ' Board  tiny  sha256 9f2c
3 ' Recipe smt-aqueous  sha256 77b0
4 ' Cell   bench  robot arm
5 ' Planned time 3.6 s, each loop once
6 ' Predicted time 3.6 s by this controller's model, 1.01 x planned
7 ' Worst event error 0.01 mm, 52.5 ms at predicted speeds (s/pass)
8 ' Worst event error 0.03 mm, 7.1 ms at planned speeds (s/pass)
9 ' Controller class 3; cycle 7.1 ms is in the error
10 ' Analog aoPressure: 0 V is 0, 10 V is 10000
11 ' Analog aiResistivity: 0 V is 0, 10 V is 10000
12 ' Waits for part present (30 s), door closed (12.5 s), pressure at least 3 bar (20 s)
13 ' Does not wait for temperature: the cell maps no such input
14 ' Stops, valves shut, without door closed: the valves by itself, the robot as wired
15 ' Parts: 1 clean, 2 clean, 3 clean
16 ' To finish a stopped board from part 2 to 3: enter its number in M_19; its way from home was not checked
17 ' Outputs left as they are at the end: aoPressure, goMedium
18 ' Shared with other programs of this cell: WBSHUT and WBWATCH, the same in each; M_19
19 ' Set up: WBWATCH in slot 2: shuts valves while slot 1 does not run, at errors, without what is watched
20 ' M_19 is the part to start at; after a stop reset the program; errors 9100 up are used
21 ' Output aoPressure: M_Outw(1), 2 * pressure_bar + 0.5 in V
22 ' Output doWash: M_Out(1), opens ring60
23 ' Output doAir: M_Out(2), opens knife
24 ' Output goMedium: M_Outb(1), 1 for saponifier-15, 2 for di-water, 3 for hot-air
25 ' Input diPart: M_In(3), part present when on
26 ' Input diDoor: M_In(4), door closed when off, watched
27 ' Input aiPressure: M_Inw(2), pressure, supply_bar = 1.25 * reading - 2.5
28 ' Input aiResistivity: M_Inw(1), ends loops, resistivity_mohm_cm = 2 * reading
29 ' Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z
30 Ovrd 100
31 Cnt 0
32 ' error 9100: the speed override is not 100 percent
33 If M_OPovrd<>100 Then Error 9100
34 CallP "WBSHUT"
35 ' error 9101: no part present
36 M_Timer(1)=0
37 *WAIT1
38 If M_In(3)=1 Then GoTo *READY1
39 If M_Timer(1)<30000 Then GoTo *WAIT1
40 Error 9101
41 *READY1
42 ' error 9102: close the door
43 M_Timer(1)=0
44 *WAIT2
45 If M_In(4)=0 Then GoTo *READY2
46 If M_Timer(1)<12500 Then GoTo *WAIT2
47 Error 9102
48 *READY2
49 ' error 9103: no pressure
50 M_Timer(1)=0
51 *WAIT3
52 If (0.00125*M_Inw(2)+-2.5)>=3 Then GoTo *READY3
53 If M_Timer(1)<20000 Then GoTo *WAIT3
54 Error 9103
55 *READY3
56 Base P_NBase
57 Tool PTL1
58 PSTART=P_Curr
59 If PSTART.Z>=145.0 Then GoTo *HIGH
60 PSTART.Z=145.0
61 Spd 100
62 Mvs PSTART
63 *HIGH
64 JOvrd 10
65 Mov J1
66 If M_19<=1 Then CallP "TINYSMSX4501"
67 ' until resistivity_mohm_cm >= 1, 4 times at most
68 M1=0
69 *LOOP1
70 M1=M1+1
71 If M_19<=2 Then CallP "TINYSMSX4502"
72 If M1<4 And (0.002*M_Inw(1)+0)<1 Then GoTo *LOOP1
73 If M_19<=3 Then CallP "TINYSMSX4503"
74 JOvrd 10
75 Mov J1
76 Base P_NBase
77 Tool P_NTool
78 End
PTL1=(0.000,30.000,142.500,0.0000,45.0000,0.0000)(0,0)
J1=(0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000)
