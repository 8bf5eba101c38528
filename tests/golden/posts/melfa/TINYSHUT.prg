1 M_Out(1)=0
2 End
