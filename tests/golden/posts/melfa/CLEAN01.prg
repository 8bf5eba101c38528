1 M_Out(1)=0
2 Base PBS0
3 ' function clean
4 ' nozzle ring60, tool 1
5 Tool PTL1
6 ' solution saponifier-15
7 M_Outb(1)=1
8 ' pressure_bar = 3.500
9 M_Outw(1)=7500
10 ' s/transfer
11 Cnt 0
12 JOvrd 10
13 Mov P1
14 Spd 163
15 Mvs P2
16 End
PBS0=(-286.160,304.356,-35.250,0.0000,0.0000,-30.0000)(0,0)
PTL1=(0.000,30.000,142.500,0.0000,45.0000,0.0000)(0,0)
P1=(0.000,0.000,110.000,180.0000,0.0000,0.0000)(7,0)
P2=(0.000,0.000,50.000,180.0000,0.0000,0.0000)(7,0)
