/PROG  TINY_01
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 13;
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
   3:  UFRAME_NUM=1 ;
   4:  !function clean ;
   5:  !nozzle ring60, tool 1 ;
   6:  UTOOL_NUM=1 ;
   7:  !solution saponifier-15 ;
   8:  GO[1]=1 ;
   9:  !pressure_bar = 3.500 ;
  10:  AO[1]=1500 ;
  11:  !s/transfer ;
  12:J P[1] 10% FINE ;
  13:L P[2] 163mm/sec FINE ;
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
