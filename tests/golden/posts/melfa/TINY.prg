1 ' Mitsubishi MELFA-BASIC, written by Washboard
2 ' Board  tiny  sha256 9f2c
3 ' Recipe smt-aqueous  sha256 77b0
4 ' Cell   bench  robot arm
5 ' Planned time 3.6 s, each loop once
6 ' Worst event error 0.03 mm, 7.1 ms at planned speeds (s/pass)
7 ' Controller class 3; cycle 7.1 ms is in the error
8 ' Output aoPressure: analog 1
9 ' Output doWash: digital 1
10 ' Output goMedium: group 1
11 ' Units: mm, mm/s, degrees; positions in the board's CAD frame, A B C about the fixed x, y, z
12 Ovrd 100
13 JOvrd 10
14 Cnt 0
15 Mov J1
16 CallP "CLEAN01"
17 ' until resistivity_mohm_cm >= 1, 4 times at most
18 M1=0
19 *LOOP1
20 M1=M1+1
21 CallP "CLEAN02"
22 If M1<4 And (0.002*M_Inw(1)+0)<1 Then GoTo *LOOP1
23 CallP "CLEAN03"
24 Mov J1
25 Base P_NBase
26 Tool P_NTool
27 End
J1=(0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000)
