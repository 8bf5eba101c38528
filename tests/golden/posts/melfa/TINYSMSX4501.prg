1 M_Out(1)=0
2 M_Out(2)=0
3 Base PBS0
4 ' function clean
5 ' nozzle ring60, tool 1
6 Tool PTL1
7 ' solution saponifier-15
8 M_Outb(1)=1
9 ' pressure_bar = 3.500
10 M_Outw(1)=7500
11 ' s/transfer
12 Cnt 0
13 JOvrd 10
14 Mov P1
15 Spd 97.4
16 Mvs P2
17 End
PBS0=(-286.160,304.356,-35.250,0.0000,0.0000,-30.0000)(0,0)
PTL1=(0.000,30.000,142.500,0.0000,45.0000,0.0000)(0,0)
P1=(0.000,0.000,110.000,180.0000,0.0000,0.0000)(7,0)
P2=(0.000,0.000,50.000,180.0000,0.0000,0.0000)(7,0)
