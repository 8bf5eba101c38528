1 ' Mitsubishi MELFA-BASIC, written by Washboard
2 ' Board  tiny  sha256 9f2c
3 ' Recipe smt-aqueous  sha256 77b0
4 ' Cell   bench  robot arm
5 ' Planned time 3.6 s, each loop once
6 ' Worst event error 0.03 mm, 7.1 ms at planned speeds (s/pass)
7 ' Controller class 3; cycle 7.1 ms is in the error
8 ' Analog aoPressure: 0 V is 0, 10 V is 10000
9 ' Analog aiResistivity: 0 V is 0, 10 V is 10000
10 ' Output aoPressure: analog 1
11 ' Output doWash: digital 1
12 ' Output goMedium: group 1
13 ' Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z
14 Ovrd 100
15 JOvrd 10
16 Cnt 0
17 Mov J1
18 CallP "CLEAN01"
19 ' until resistivity_mohm_cm >= 1, 4 times at most
20 M1=0
21 *LOOP1
22 M1=M1+1
23 CallP "CLEAN02"
24 If M1<4 And (0.002*M_Inw(1)+0)<1 Then GoTo *LOOP1
25 CallP "CLEAN03"
26 Mov J1
27 Base P_NBase
28 Tool P_NTool
29 End
J1=(0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000)
