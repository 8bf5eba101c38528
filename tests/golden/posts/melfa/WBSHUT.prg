1 M_Out(1)=0
2 M_Out(2)=0
3 End
