1 ' Mitsubishi MELFA-BASIC, written by Washboard
2 ' Board  tiny  sha256 9f2c
3 ' Recipe smt-aqueous  sha256 77b0
4 ' Cell   bench  robot arm
5 ' Planned time 3.6 s, each loop once
6 ' Predicted time 3.1 s by this controller's model, 0.85 x planned
7 ' Worst event error 0.01 mm, 52.5 ms at predicted speeds (s/pass)
8 ' Worst event error 0.03 mm, 7.1 ms at planned speeds (s/pass)
9 ' Controller class 3; cycle 7.1 ms is in the error
10 ' Analog aoPressure: 0 V is 0, 10 V is 10000
11 ' Analog aiResistivity: 0 V is 0, 10 V is 10000
12 ' Waits for part present (30 s), door closed (12.5 s), pressure at least 3 bar (20 s)
13 ' Does not wait for temperature: the cell maps no such input
14 ' Stops, valves shut, without door closed: the valves by itself, the robot as wired, see below
15 ' Parts: 1 clean, 2 clean, 3 clean
16 ' To finish a stopped board from part 2 to 3: enter its number in M_19; its way from home was not checked
17 ' Set up: TINYWATCH in slot 2 (SLT2: TINYWATCH,REP,ALWAYS,1): shuts valves while slot 1 does not
18 ' Set up: run, after an error, and without what is watched; wire that to stop the robot too
19 ' Set up: M_19 is the part to start at; after a stop reset the program; errors 9100 up are used
20 ' Output aoPressure: analog 1
21 ' Output doWash: digital 1, opens ring60
22 ' Output goMedium: group 1
23 ' Input diPart: digital 3, part present
24 ' Input diDoor: digital 4, door closed
25 ' Input aiPressure: analog 2, pressure
26 ' Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z
27 Ovrd 100
28 Cnt 0
29 ' error 9100: the speed override is not 100 percent
30 If M_OPovrd<>100 Then Error 9100
31 CallP "TINYSHUT"
32 ' error 9101: no part present
33 M_Timer(1)=0
34 *WAIT1
35 If M_In(3)=1 Then GoTo *READY1
36 If M_Timer(1)<30000 Then GoTo *WAIT1
37 Error 9101
38 *READY1
39 ' error 9102: close the door
40 M_Timer(1)=0
41 *WAIT2
42 If M_In(4)=0 Then GoTo *READY2
43 If M_Timer(1)<12500 Then GoTo *WAIT2
44 Error 9102
45 *READY2
46 ' error 9103: no pressure
47 M_Timer(1)=0
48 *WAIT3
49 If (0.00125*M_Inw(2)+-2.5)>=3 Then GoTo *READY3
50 If M_Timer(1)<20000 Then GoTo *WAIT3
51 Error 9103
52 *READY3
53 Base P_NBase
54 Tool PTL1
55 PSTART=P_Curr
56 If PSTART.Z>=145.0 Then GoTo *HIGH
57 PSTART.Z=145.0
58 Spd 100
59 Mvs PSTART
60 *HIGH
61 JOvrd 10
62 Mov J1
63 If M_19<=1 Then CallP "CLEAN01"
64 ' until resistivity_mohm_cm >= 1, 4 times at most
65 M1=0
66 *LOOP1
67 M1=M1+1
68 If M_19<=2 Then CallP "CLEAN02"
69 If M1<4 And (0.002*M_Inw(1)+0)<1 Then GoTo *LOOP1
70 If M_19<=3 Then CallP "CLEAN03"
71 JOvrd 10
72 Mov J1
73 Base P_NBase
74 Tool P_NTool
75 End
PTL1=(0.000,30.000,142.500,0.0000,45.0000,0.0000)(0,0)
J1=(0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000)
