/PROG  TINY
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 22;
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
   7:  UFRAME_NUM=1 ;
   8:  UTOOL_NUM=1 ;
   9:J P[1] 10% FINE ;
  10:  CALL TINY_01 ;
  11:  !until resistivity_mohm_cm >= 1 ;
  12:  R[91]=0 ;
  13:  LBL[1] ;
  14:  R[91]=R[91]+1 ;
  15:  CALL TINY_02 ;
  16:  R[90]=AI[1]*0.01 ;
  17:  R[90]=R[90]+0 ;
  18:  IF R[91]<4 AND R[90]<1,JMP LBL[1] ;
  19:  CALL TINY_03 ;
  20:  UFRAME_NUM=1 ;
  21:  UTOOL_NUM=1 ;
  22:J P[1] 10% FINE ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,
	J1 =     0.0000 deg,	J2 =   -28.6479 deg,	J3 =    63.0254 deg,
	J4 =     0.0000 deg,	J5 =    68.7549 deg,	J6 =     0.0000 deg
};
/END
