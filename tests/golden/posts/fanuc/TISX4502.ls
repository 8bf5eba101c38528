/PROG  TISX4502
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 20;
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
   1:  !clean ;
   2:  UFRAME_NUM=1 ;
   3:  UTOOL_NUM=1 ;
   4:  IF R[89]<>2,JMP LBL[99] ;
   5:  R[89]=1 ;
   6:  GO[1]=1 ;
   7:  AO[1]=1500 ;
   8:J P[1] 10% FINE ;
   9:L P[2] 617cm/min FINE ;
  10:  LBL[99] ;
  11:  DO[1]=ON ;
  12:  !s/pass ;
  13:  WAIT .04(sec) ;
  14:L P[3] 350cm/min FINE TB .02sec,DO[1]=OFF ;
  15:  !s/transfer ;
  16:L P[4] 325cm/min FINE TB .04sec,DO[1]=ON ;
  17:  !s/pass ;
  18:L P[5] 350cm/min FINE TB .02sec,DO[1]=OFF ;
  19:  !s/transfer ;
  20:L P[6] 325cm/min FINE ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.000  mm,	Y =     0.000  mm,	Z =   110.000  mm,
	W =   180.0000 deg,	P =     0.0000 deg,	R =     0.0000 deg
};
P[2]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.000  mm,	Y =     0.000  mm,	Z =    50.000  mm,
	W =   180.0000 deg,	P =     0.0000 deg,	R =     0.0000 deg
};
P[3]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    40.000  mm,	Y =     0.000  mm,	Z =    50.000  mm,
	W =   180.0000 deg,	P =     0.0000 deg,	R =     0.0000 deg
};
P[4]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    40.000  mm,	Y =    10.000  mm,	Z =    50.000  mm,
	W =   180.0000 deg,	P =     0.0000 deg,	R =     0.0000 deg
};
P[5]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.000  mm,	Y =    10.000  mm,	Z =    50.000  mm,
	W =   180.0000 deg,	P =     0.0000 deg,	R =     0.0000 deg
};
P[6]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.000  mm,	Y =     0.000  mm,	Z =    50.000  mm,
	W =   180.0000 deg,	P =     0.0000 deg,	R =     0.0000 deg
};
/END
