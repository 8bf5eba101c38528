/PROG  TINY
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 61;
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
   4:  !Time 3.2 s, 0.89 x plan ;
   5:  !Event error 0.04 mm, 8.0 ms ;
   6:  !Frames: see TINY.txt ;
   7:  R[88]=$MCR.$GENOVERRIDE ;
   8:  IF R[88]=100,JMP LBL[88] ;
   9:  MESSAGE[OVERRIDE IS NOT 100] ;
  10:  ABORT ;
  11:  LBL[88] ;
  12:  CALL TINY_SH ;
  13:  $WAITTMOUT=3000 ;
  14:  WAIT DI[3]=ON TIMEOUT,LBL[301] ;
  15:  JMP LBL[401] ;
  16:  LBL[301] ;
  17:  MESSAGE[no part present] ;
  18:  ABORT ;
  19:  LBL[401] ;
  20:  $WAITTMOUT=1250 ;
  21:  WAIT DI[4]=OFF TIMEOUT,LBL[302] ;
  22:  JMP LBL[402] ;
  23:  LBL[302] ;
  24:  MESSAGE[close the door] ;
  25:  ABORT ;
  26:  LBL[402] ;
  27:  R[88]=0 ;
  28:  LBL[303] ;
  29:  R[90]=AI[2]*0.00625 ;
  30:  R[90]=R[90]+(-2.5) ;
  31:  IF R[90]>=3,JMP LBL[403] ;
  32:  WAIT .10(sec) ;
  33:  R[88]=R[88]+1 ;
  34:  IF R[88]<200,JMP LBL[303] ;
  35:  MESSAGE[no pressure] ;
  36:  ABORT ;
  37:  LBL[403] ;
  38:  UFRAME_NUM=0 ;
  39:  UTOOL_NUM=1 ;
  40:  PR[91]=LPOS ;
  41:  R[88]=PR[91,3] ;
  42:  IF R[88]>=145,JMP LBL[98] ;
  43:  PR[91,3]=145 ;
  44:L PR[91] 100mm/sec FINE ;
  45:  LBL[98] ;
  46:  UFRAME_NUM=1 ;
  47:  UTOOL_NUM=1 ;
  48:J P[1] 10% FINE ;
  49:  IF R[89]<=1,CALL TINY_01 ;
  50:  !until resistivity_mohm_cm >= 1 ;
  51:  R[91]=0 ;
  52:  LBL[1] ;
  53:  R[91]=R[91]+1 ;
  54:  IF R[89]<=2,CALL TINY_02 ;
  55:  R[90]=AI[1]*0.01 ;
  56:  R[90]=R[90]+0 ;
  57:  IF R[91]<4 AND R[90]<1,JMP LBL[1] ;
  58:  IF R[89]<=3,CALL TINY_03 ;
  59:  UFRAME_NUM=1 ;
  60:  UTOOL_NUM=1 ;
  61:J P[1] 10% FINE ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,
	J1 =     0.0000 deg,	J2 =   -28.6479 deg,	J3 =    63.0254 deg,
	J4 =     0.0000 deg,	J5 =    68.7549 deg,	J6 =     0.0000 deg
};
/END
