/PROG  TISX45FR
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Washboard";
PROG_SIZE	= 0;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 16;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= *,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Enter the frames of the cell ;
   2:  PR[91]=LPOS ;
   3:  PR[91,1]=0 ;
   4:  PR[91,2]=30 ;
   5:  PR[91,3]=142.5 ;
   6:  PR[91,4]=0 ;
   7:  PR[91,5]=45 ;
   8:  PR[91,6]=0 ;
   9:  UTOOL[1]=PR[91] ;
  10:  PR[91,1]=400 ;
  11:  PR[91,2]=(-120.5) ;
  12:  PR[91,3]=35.25 ;
  13:  PR[91,4]=0 ;
  14:  PR[91,5]=0 ;
  15:  PR[91,6]=30 ;
  16:  UFRAME[1]=PR[91] ;
/POS
/END
