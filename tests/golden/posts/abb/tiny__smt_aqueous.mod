MODULE tiny__smt_aqueous
  ! ABB RAPID, written by Washboard
  ! Board  tiny  sha256 9f2c
  ! Recipe smt-aqueous  sha256 77b0
  ! Cell   bench  robot arm
  ! Planned time 3.6 s, each loop once
  ! Predicted time 3.6 s by this controller's model, 1.01 x planned
  ! Worst event error 0.00 mm, 50.0 ms at predicted speeds (s/pass)
  ! Worst event error 0.01 mm, 2.0 ms at planned speeds (s/pass)
  ! Controller class 1; cycle 2 ms is in the error
  ! Analog aoPressure: 0 V is 0, 10 V is 10
  ! Analog aiResistivity: 0 V is 0, 10 V is 10
  ! Waits for part present (30 s), door closed (12.5 s), pressure at least 3 bar (20 s)
  ! Does not wait for temperature: the cell maps no such input
  ! Stops, valves shut, without door closed
  ! Parts: 1 clean, 2 clean, 3 clean
  ! To finish a stopped board from part 2 to 3: set nStart to its number; its way from home was not checked
  ! Outputs left as they are at the end: aoPressure, goMedium
  ! Shared with other programs of this cell: main, its routines and data have the same names: one program is loaded at a time
  ! Set up: event routine shut_valves for Stop and QStop (Controller, Event Routine): a stop shuts no output
  ! Set up: the signals below in the I/O configuration, on your devices
  ! Set up: identify the loads of the tools: 1 kg stands where the cell states none
  ! After a stop start from main (PP to Main)
  ! tooldata and wobjdata are in this module: compare them with yours
  ! Output aoPressure: AO aoPressure, 2 * pressure_bar + 0.5 in V
  ! Output doWash: DO doWash, opens ring60
  ! Output doAir: DO doAir, opens knife
  ! Output goMedium: GO goMedium, 1 for saponifier-15, 2 for di-water, 3 for hot-air
  ! Input diPart: DI diPart, part present when on
  ! Input diDoor: DI diDoor, door closed when off, watched
  ! Input aiPressure: AI aiPressure, pressure, supply_bar = 1.25 * reading - 2.5
  ! Input aiResistivity: AI aiResistivity, ends loops, resistivity_mohm_cm = 2 * reading
  ! Units: mm, s, mm/s, deg/s; targets in the board's CAD frame.
  PERS tooldata t_ring60:=[TRUE,[[0.000,30.000,142.500],[0.9238795,0.0000000,0.3826834,0.0000000]],[0.8,[0,0,71.2],[1,0,0,0],0,0,0]];
  PERS wobjdata w_board:=[FALSE,TRUE,"",[[400.000,-120.500,35.250],[0.9659258,0.0000000,0.0000000,0.2588190]],[[0,0,0],[1,0,0,0]]];
  VAR robtarget pStart:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget jHome:=[[0.0000,-28.6479,34.3775,0.0000,68.7549,0.0000],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata s100:=[100,500,5000,1000];
  CONST speeddata s90p3:=[90.3,500,5000,1000];
  CONST speeddata s53p7:=[53.7,500,5000,1000];
  CONST speeddata s41p3:=[41.3,500,5000,1000];
  VAR triggdata ev1;
  VAR triggdata ev2;
  PERS num nStart:=1;
  VAR bool bLate:=FALSE;
  VAR intnum irFault;
  VAR intnum irWatch2;
  VAR num nLoop1:=0;

  LOCAL CONST robtarget p1:=[[0.000,0.000,110.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p2:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p3:=[[0.000,0.000,110.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p4:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p5:=[[40.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p6:=[[40.000,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p7:=[[0.000,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p8:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p9:=[[0.000,0.000,110.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p10:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p11:=[[40.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p12:=[[40.000,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p13:=[[0.000,10.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p14:=[[0.000,0.000,50.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  LOCAL CONST robtarget p15:=[[0.000,0.000,110.000],[0.0000000,1.0000000,0.0000000,0.0000000],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    ConfJ\Off;
    ConfL\Off;
    define_events;
    IF CSpeedOverride()<>100 stop_job "speed override is not 100 percent";
    shut_valves;
    WaitDI diPart,1\MaxTime:=30\TimeFlag:=bLate;
    IF bLate stop_job "no part present";
    WaitDI diDoor,0\MaxTime:=12.5\TimeFlag:=bLate;
    IF bLate stop_job "close the door";
    WaitUntil 1.25*AInput(aiPressure)+-2.5>=3\MaxTime:=20\TimeFlag:=bLate;
    IF bLate stop_job "no pressure";
    IDelete irWatch2;
    CONNECT irWatch2 WITH on_fault;
    ISignalDI diDoor,1,irWatch2;
    IDelete irFault;
    CONNECT irFault WITH on_fault;
    IError COMMON_ERR,TYPE_ERR,irFault;
    pStart:=CRobT(\Tool:=t_ring60\WObj:=wobj0);
    IF pStart.trans.z<145.0 THEN
      pStart.trans.z:=145.0;
      MoveL pStart,s100,fine,t_ring60\WObj:=wobj0;
    ENDIF
    MoveAbsJ jHome\NoEOffs,s100,fine,t_ring60;
    IF nStart<=1 clean_01;
    ! until resistivity_mohm_cm >= 1, 4 times at most
    nLoop1:=0;
    WHILE nLoop1<4 AND (nLoop1=0 OR 2*AInput(aiResistivity)+0<1) DO
      nLoop1:=nLoop1+1;
      IF nStart<=2 clean_02;
    ENDWHILE
    IF nStart<=3 clean_03;
    MoveAbsJ jHome\NoEOffs,s100,fine,t_ring60;
    IDelete irWatch2;
    IDelete irFault;
  ERROR
    shut_valves;
    RAISE;
  ENDPROC

  PROC shut_valves()
    SetDO doWash,0;
    SetDO doAir,0;
  ENDPROC

  PROC stop_job(string sText)
    shut_valves;
    TPWrite "Washboard: "+sText;
    EXIT;
  ENDPROC

  TRAP on_fault
    StopMove\Quick;
    shut_valves;
    TPWrite "Washboard: fault, valves shut";
    EXIT;
  ENDTRAP

  PROC define_events()
    TriggIO ev1,0.020\Time\DOp:=doWash,0;
    TriggIO ev2,0.040\Time\DOp:=doWash,1;
  ENDPROC

  PROC clean_01()
    SetDO doWash,0;
    SetDO doAir,0;
    ! function clean
    ! nozzle ring60, tool 1
    ! solution saponifier-15
    SetGO goMedium,1;
    ! pressure_bar = 3.500
    SetAO aoPressure,7.5;
    ! s/transfer
    MoveJ p1,s100,fine,t_ring60\WObj:=w_board;
    MoveL p2,s90p3,fine,t_ring60\WObj:=w_board;
  ENDPROC

  PROC clean_02()
    IF nStart=2 THEN
      nStart:=1;
      SetGO goMedium,1;
      SetAO aoPressure,7.5;
      MoveJ p3,s100,fine,t_ring60\WObj:=w_board;
      MoveL p4,s90p3,fine,t_ring60\WObj:=w_board;
    ENDIF
    SetDO doWash,1;
    ! s/pass
    WaitTime 0.040;
    TriggL p5,s53p7,ev1,fine,t_ring60\WObj:=w_board;
    ! s/transfer
    TriggL p6,s41p3,ev2,fine,t_ring60\WObj:=w_board;
    ! s/pass
    TriggL p7,s53p7,ev1,fine,t_ring60\WObj:=w_board;
    ! s/transfer
    MoveL p8,s41p3,fine,t_ring60\WObj:=w_board;
  ENDPROC

  PROC clean_03()
    IF nStart=3 THEN
      nStart:=1;
      SetGO goMedium,1;
      SetAO aoPressure,7.5;
      MoveJ p9,s100,fine,t_ring60\WObj:=w_board;
      MoveL p10,s90p3,fine,t_ring60\WObj:=w_board;
      MoveL p11,s53p7,fine,t_ring60\WObj:=w_board;
      MoveL p12,s41p3,fine,t_ring60\WObj:=w_board;
      MoveL p13,s53p7,fine,t_ring60\WObj:=w_board;
      MoveL p14,s41p3,fine,t_ring60\WObj:=w_board;
    ENDIF
    ! s/transfer
    MoveL p15,s90p3,fine,t_ring60\WObj:=w_board;
  ENDPROC

ENDMODULE
