/PROG  TISX4501
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 14;
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
   2:  DO[1]=OFF ;
   3:  DO[2]=OFF ;
   4:  UFRAME_NUM=1 ;
   5:  !function clean ;
   6:  !nozzle ring60, tool 1 ;
   7:  UTOOL_NUM=1 ;
   8:  !solution saponifier-15 ;
   9:  GO[1]=1 ;
  10:  !pressure_bar = 3.500 ;
  11:  AO[1]=1500 ;
  12:  !s/transfer ;
  13:J P[1] 10% FINE ;
  14:L P[2] 617cm/min FINE ;
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
/END
