1 *LOOP
2 If M_Run(1)=0 Then M_Out(1)=0
3 If M_Run(1)=0 Then M_Out(2)=0
4 If M_Err=1 Then M_Out(1)=0
5 If M_Err=1 Then M_Out(2)=0
6 If M_In(4)=1 Then M_Out(1)=0
7 If M_In(4)=1 Then M_Out(2)=0
8 GoTo *LOOP
9 End
