/PROG  TISX45
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 67;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Washboard: board tiny ;
   2:  !recipe smt-aqueous ;
   3:  !cell bench ;
   4:  !Time 3.6 s, 1.01 x plan ;
   5:  !Event error 0.04 mm, 8.0 ms ;
   6:  !Frames: see TISX45.txt ;
   7:  R[88]=$MCR.$GENOVERRIDE ;
   8:  IF R[88]=100,JMP LBL[88] ;
   9:  MESSAGE[OVERRIDE IS NOT 100] ;
  10:  ABORT ;
  11:  LBL[88] ;
  12:  CALL WB_SHUT ;
  13:  R[87]=$WAITTMOUT ;
  14:  $WAITTMOUT=3000 ;
  15:  WAIT DI[3]=ON TIMEOUT,LBL[301] ;
  16:  JMP LBL[401] ;
  17:  LBL[301] ;
  18:  $WAITTMOUT=R[87] ;
  19:  MESSAGE[no part present] ;
  20:  ABORT ;
  21:  LBL[401] ;
  22:  $WAITTMOUT=R[87] ;
  23:  R[87]=$WAITTMOUT ;
  24:  $WAITTMOUT=1250 ;
  25:  WAIT DI[4]=OFF TIMEOUT,LBL[302] ;
  26:  JMP LBL[402] ;
  27:  LBL[302] ;
  28:  $WAITTMOUT=R[87] ;
  29:  MESSAGE[close the door] ;
  30:  ABORT ;
  31:  LBL[402] ;
  32:  $WAITTMOUT=R[87] ;
  33:  R[88]=0 ;
  34:  LBL[303] ;
  35:  R[90]=AI[2]*0.00625 ;
  36:  R[90]=R[90]+(-2.5) ;
  37:  IF R[90]>=3,JMP LBL[403] ;
  38:  WAIT .10(sec) ;
  39:  R[88]=R[88]+1 ;
  40:  IF R[88]<200,JMP LBL[303] ;
  41:  MESSAGE[no pressure] ;
  42:  ABORT ;
  43:  LBL[403] ;
  44:  UFRAME_NUM=0 ;
  45:  UTOOL_NUM=1 ;
  46:  PR[91]=LPOS ;
  47:  R[88]=PR[91,3] ;
  48:  IF R[88]>=145,JMP LBL[98] ;
  49:  PR[91,3]=145 ;
  50:L PR[91] 100mm/sec FINE ;
  51:  LBL[98] ;
  52:  UFRAME_NUM=1 ;
  53:  UTOOL_NUM=1 ;
  54:J P[1] 10% FINE ;
  55:  IF R[89]<=1,CALL TISX4501 ;
  56:  !until resistivity_mohm_cm >= 1 ;
  57:  R[91]=0 ;
  58:  LBL[1] ;
  59:  R[91]=R[91]+1 ;
  60:  IF R[89]<=2,CALL TISX4502 ;
  61:  R[90]=AI[1]*0.01 ;
  62:  R[90]=R[90]+0 ;
  63:  IF R[91]<4 AND R[90]<1,JMP LBL[1] ;
  64:  IF R[89]<=3,CALL TISX4503 ;
  65:  UFRAME_NUM=1 ;
  66:  UTOOL_NUM=1 ;
  67:J P[1] 10% FINE ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,
	J1 =     0.0000 deg,	J2 =   -28.6479 deg,	J3 =    63.0254 deg,
	J4 =     0.0000 deg,	J5 =    68.7549 deg,	J6 =     0.0000 deg
};
/END
