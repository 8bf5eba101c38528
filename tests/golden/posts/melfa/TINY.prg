1 ' Mitsubishi MELFA-BASIC, written by Washboard
2 ' Board  tiny  sha256 9f2c
3 ' Recipe smt-aqueous  sha256 77b0
4 ' Cell   bench  robot arm
5 ' Planned time 3.6 s, each loop once
6 ' Predicted time 3.0 s by this controller's model, 0.84 x planned
7 ' Worst event error 0.00 mm, 40.6 ms at predicted speeds (s/pass)
8 ' Worst event error 0.03 mm, 7.1 ms at planned speeds (s/pass)
9 ' Controller class 3; cycle 7.1 ms is in the error
10 ' Analog aoPressure: 0 V is 0, 10 V is 10000
11 ' Analog aiResistivity: 0 V is 0, 10 V is 10000
12 ' Output aoPressure: analog 1
13 ' Output doWash: digital 1, opens ring60
14 ' Output goMedium: group 1
15 ' Input diPart: digital 3, part present
16 ' Input diDoor: digital 4, door closed
17 ' Input aiPressure: analog 2, pressure
18 ' Output aoPressure: analog 1
19 ' Output doWash: digital 1
20 ' Output goMedium: group 1
21 ' Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z
22 Ovrd 100
23 JOvrd 10
24 Cnt 0
25 Mov J1
26 CallP "CLEAN01"
27 ' until resistivity_mohm_cm >= 1, 4 times at most
28 M1=0
29 *LOOP1
30 M1=M1+1
31 CallP "CLEAN02"
32 If M1<4 And (0.002*M_Inw(1)+0)<1 Then GoTo *LOOP1
33 CallP "CLEAN03"
34 Mov J1
35 Base P_NBase
36 Tool P_NTool
37 End
J1=(0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000)
