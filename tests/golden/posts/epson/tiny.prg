' Epson SPEL+, written by Washboard
' Board  tiny  sha256 9f2c
' Recipe smt-aqueous  sha256 77b0
' Cell   bench  robot arm
' Planned time 3.6 s, each loop once
' Predicted time 3.0 s by this controller's model, 0.84 x planned
' Worst event error 0.00 mm, 30.0 ms at predicted speeds (s/pass)
' Worst event error 0.04 mm, 22.0 ms at planned speeds (s/pass)
' Controller class 2; cycle 2 ms is in the error
' Analog aoPressure: 0 V is 0, 10 V is 10
' Analog aiResistivity: 0 V is 0, 10 V is 10
' Output aoPressure: analog 1
' Output doWash: digital 1, opens ring60
' Output goMedium: group 1
' Input diPart: digital 3, part present
' Input diDoor: digital 4, door closed
' Input aiPressure: analog 2, pressure
' Output aoPressure: analog 1
' Output doWash: digital 1
' Output goMedium: group 1
' Units: mm, mm/s, deg/s; points in the board's CAD frame (Local), U V W about z, y', x''.
Function main
  Integer nLoop1
  Motor On
  Power High
  Speed 10
  Accel 20, 20
  SpeedS 100
  AccelS 2000, 2000
  SpeedR 90
  AccelR 1000, 1000
  TLSet 1, XY(0.000, 30.000, 142.500, 0.0000, 45.0000, 0.0000) ' ring60
  Local 1, XY(400.000, -120.500, 35.250, 30.0000, 0.0000, 0.0000) ' board as mounted
  Go JA(0.0000, -28.6479, 34.3775, 0.0000, 68.7549, 0.0000) ' home
  Call clean_01
  ' until resistivity_mohm_cm >= 1, 4 times at most
  nLoop1 = 0
  Do
    nLoop1 = nLoop1 + 1
    Call clean_02
  Loop While nLoop1 < 4 And 2 * AIO_In(1) + 0 < 1
  Call clean_03
  Go JA(0.0000, -28.6479, 34.3775, 0.0000, 68.7549, 0.0000) ' home
Fend

Function clean_01
  Off 1
  ' function clean
  ' nozzle ring60, tool 1
  Tool 1
  ' solution saponifier-15
  Out 1, 1
  ' pressure_bar = 3.500
  AIO_Out 1, 7.5
  ' s/transfer
  Go XY(0.000, 0.000, 110.000, 0.0000, 0.0000, 180.0000) /1
  SpeedS 163.0
  Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
Fend

Function clean_02
  Tool 1
  On 1
  ' s/pass
  Wait 0.040
  SpeedS 60.0
  Move XY(40.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1 !D100; Off 1!
  ' s/transfer
  SpeedS 63.6
  Move XY(40.000, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1 !D96; On 1!
  ' s/pass
  SpeedS 60.0
  Move XY(0.000, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1 !D100; Off 1!
  ' s/transfer
  SpeedS 63.6
  Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
Fend

Function clean_03
  Tool 1
  ' s/transfer
  SpeedS 163.0
  Move XY(0.000, 0.000, 110.000, 0.0000, 0.0000, 180.0000) /1
Fend

