MODULE tiny
  ! ABB RAPID, RobotWare Paint, written by Washboard
  ! Board  tiny  sha256 9f2c
  ! Recipe smt-aqueous  sha256 77b0
  ! Cell   bench  robot arm
  ! Planned time 3.6 s, each loop once
  ! Predicted time 2.7 s by this controller's model, 0.76 x planned
  ! Worst event error 0.00 mm, 40.0 ms at predicted speeds (s/pass)
  ! Worst event error 0.02 mm, 4.0 ms at planned speeds (s/pass)
  ! Controller class 3; cycle 4 ms is in the error
  ! Analog aoPressure: 0 V is 0, 10 V is 10
  ! Analog aiResistivity: 0 V is 0, 10 V is 10
  ! Output aoPressure: analog 1
  ! Output doWash: digital 1, opens ring60
  ! Output goMedium: group 1
  ! Input diPart: digital 3, part present
  ! Input diDoor: digital 4, door closed
  ! Input aiPressure: analog 2, pressure
  ! Units: mm, s, mm/s, deg/s; targets in the board's CAD frame.
  PERS tooldata t_ring60:=[TRUE,[[0.000,30.000,142.500],[0.9238795,0.0000000,0.3826834,0.0000000]],[0.8,[0,0,71.2],[1,0,0,0],0,0,0]];
  PERS wobjdata w_board:=[FALSE,TRUE,"",[[400.000,-120.500,35.250],[0.9659258,0.0000000,0.0000000,0.2588190]],[[0,0,0],[1,0,0,0]]];
  CONST jointtarget jHome:=[[0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata s100:=[100,500,5000,1000];
  CONST speeddata s163:=[163,500,5000,1000];
  CONST speeddata s60:=[60,500,5000,1000];
  CONST speeddata s63p6:=[63.6,500,5000,1000];
  VAR num nLoop1:=0;
  CONST string sBrush1:="doWash";

  LOCAL CONST robtarget p1:=[[0.000,0.000,110.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p2:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p3:=[[39.902,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p4:=[[40.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p5:=[[40.000,9.617,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p6:=[[40.000,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p7:=[[0.098,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p8:=[[0.000,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p9:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p10:=[[0.000,0.000,110.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    ConfJ\Off;
    ConfL\Off;
    define_events;
    MoveAbsJ jHome\NoEOffs,s100,fine,t_ring60;
    clean_01;
    ! until resistivity_mohm_cm >= 1, 4 times at most
    nLoop1:=0;
    WHILE nLoop1<4 AND (nLoop1=0 OR 2*AInput(aiResistivity)+0<1) DO
      nLoop1:=nLoop1+1;
      clean_02;
    ENDWHILE
    clean_03;
    MoveAbsJ jHome\NoEOffs,s100,fine,t_ring60;
  ENDPROC

  PROC define_events()
  ENDPROC

  PROC clean_01()
    SetBrush 0;
    ! function clean
    ! nozzle ring60, tool 1
    ! solution saponifier-15
    SetGO goMedium,1;
    ! pressure_bar = 3.500
    SetAO aoPressure,7.5;
    ! s/transfer
    MoveJ p1,s100,fine,t_ring60\WObj:=w_board;
    PaintL p2,s163,fine,t_ring60\WObj:=w_board;
  ENDPROC

  PROC clean_02()
    SetBrush 1;
    ! s/pass
    WaitTime 0.040;
    PaintL p3,s60,z0,t_ring60\WObj:=w_board;
    SetBrush 0;
    PaintL p4,s60,fine,t_ring60\WObj:=w_board;
    ! s/transfer
    PaintL p5,s63p6,z0,t_ring60\WObj:=w_board;
    SetBrush 1;
    PaintL p6,s63p6,fine,t_ring60\WObj:=w_board;
    ! s/pass
    PaintL p7,s60,z0,t_ring60\WObj:=w_board;
    SetBrush 0;
    PaintL p8,s60,fine,t_ring60\WObj:=w_board;
    ! s/transfer
    PaintL p9,s63p6,fine,t_ring60\WObj:=w_board;
  ENDPROC

  PROC clean_03()
    ! s/transfer
    PaintL p10,s163,fine,t_ring60\WObj:=w_board;
  ENDPROC

ENDMODULE
