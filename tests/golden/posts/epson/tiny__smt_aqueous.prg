' Epson SPEL+, written by Washboard
' Board  tiny  sha256 9f2c
' Recipe smt-aqueous  sha256 77b0
' Cell   bench  robot arm
' Planned time 3.6 s, each loop once
' Predicted time 3.6 s by this controller's model, 1.01 x planned
' Worst event error 0.01 mm, 52.5 ms at predicted speeds (s/pass)
' Worst event error 0.02 mm, 3.2 ms at planned speeds (s/pass)
' Controller class 2; cycle 2 ms is in the error
' Analog aoPressure: 0 V is 0, 10 V is 10
' Analog aiResistivity: 0 V is 0, 10 V is 10
' Waits for part present (30 s), door closed (12.5 s), pressure at least 3 bar (20 s)
' Does not wait for temperature: the cell maps no such input
' Stops, valves shut, without door closed
' Parts: 1 clean, 2 clean, 3 clean
' To finish a stopped board from part 2 to 3: set nStart to its number; its way from home was not checked
' Outputs left as they are at the end: aoPressure, goMedium
' Shared with other programs of this cell: main, shut_valves, stop_job, on_fault, nStart: each program has a project of...
' Set up: preferences: outputs off at an emergency stop; a background task shuts the valves while no task runs
' Set up: AccelS and AccelR of this arm in main
' Set up: the option for analog I/O
' Trap numbers below 5 are used; nStart, the part to start at, is kept when the controller is switched off
' Output aoPressure: analog output 1, 2 * pressure_bar + 0.5 in V
' Output doWash: output bit 1, opens ring60
' Output doAir: output bit 2, opens knife
' Output goMedium: output port 1, 1 for saponifier-15, 2 for di-water, 3 for hot-air
' Input diPart: input bit 3, part present when on
' Input diDoor: input bit 4, door closed when off, watched
' Input aiPressure: analog input 2, pressure, supply_bar = 1.25 * reading - 2.5
' Input aiResistivity: analog input 1, ends loops, resistivity_mohm_cm = 2 * reading
' Units: mm, mm/s, deg/s; points in the board's CAD frame (Local), U V W about z, y', x''.
Global Preserve Integer nStart

Function main
  Integer nLoop1
  Motor On
  Power High
  Accel 100, 100
  SpeedS 100
  AccelS 2000, 2000
  SpeedR 90
  AccelR 1000, 1000
  TLSet 1, XY(0.000, 30.000, 142.500, 0.0000, 45.0000, 0.0000) ' ring60
  Local 1, XY(400.000, -120.500, 35.250, 30.0000, 0.0000, 0.0000) ' board as mounted
  Trap Error Xqt on_fault
  Trap Emergency Xqt on_fault
  Trap Abort Xqt on_fault
  If SpeedFactor <> 100 Then Call stop_job("speed factor is not 100")
  Call shut_valves
  Wait Sw(3) = On, 30
  If TW = True Then Call stop_job("no part present")
  Wait Sw(4) = Off, 12.5
  If TW = True Then Call stop_job("close the door")
  TmReset 0
  Do While 1.25 * AIO_In(2) + -2.5 < 3 And Tmr(0) < 20
    Wait 0.1
  Loop
  If 1.25 * AIO_In(2) + -2.5 < 3 Then Call stop_job("no pressure")
  Trap 1, Sw(4) = On Xqt on_fault
  Tool 1
  If CZ(Here) < 145.0 Then Move Here :Z(145.0)
  Speed 10
  Go JA(0.0000, -28.6479, 34.3775, 0.0000, 68.7549, 0.0000) ' home
  If nStart <= 1 Then Call tiny__smt_aqueous_01
  ' until resistivity_mohm_cm >= 1, 4 times at most
  nLoop1 = 0
  Do
    nLoop1 = nLoop1 + 1
    If nStart <= 2 Then Call tiny__smt_aqueous_02
  Loop While nLoop1 < 4 And 2 * AIO_In(1) + 0 < 1
  If nStart <= 3 Then Call tiny__smt_aqueous_03
  Speed 10
  Go JA(0.0000, -28.6479, 34.3775, 0.0000, 68.7549, 0.0000) ' home
  Trap 1
  Trap Error
  Trap Emergency
  Trap Abort
Fend

Function shut_valves
  Off 1, Forced
  Off 2, Forced
Fend

Function stop_job(text$ As String)
  Call shut_valves
  Print "Washboard: ", text$
  Quit All
Fend

Function on_fault
  Call shut_valves
  Print "Washboard: fault, valves shut"
  Quit All
Fend

Function tiny__smt_aqueous_01
  Off 1
  Off 2
  ' function clean
  ' nozzle ring60, tool 1
  Tool 1
  ' solution saponifier-15
  Out 1, 1
  ' pressure_bar = 3.500
  AIO_Out 1, 7.5
  ' s/transfer
  Speed 10
  Go XY(0.000, 0.000, 110.000, 0.0000, 0.0000, 180.0000) /1
  SpeedS 97.4
  Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
Fend

Function tiny__smt_aqueous_02
  Tool 1
  If nStart = 2 Then
    nStart = 1
    Out 1, 1
    AIO_Out 1, 7.5
    Speed 10
    Go XY(0.000, 0.000, 110.000, 0.0000, 0.0000, 180.0000) /1
    SpeedS 97.4
    Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
  EndIf
  On 1
  ' s/pass
  Wait 0.040
  SpeedS 57.3
  Move XY(39.882, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1 CP
  SpeedS 5.6
  Move XY(40.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1 !D0; Off 1!
  ' s/transfer
  SpeedS 45.6
  Move XY(40.000, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1 !D96; On 1!
  ' s/pass
  SpeedS 57.3
  Move XY(0.118, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1 CP
  SpeedS 5.6
  Move XY(0.000, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1 !D0; Off 1!
  ' s/transfer
  SpeedS 45.6
  Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
Fend

Function tiny__smt_aqueous_03
  Tool 1
  If nStart = 3 Then
    nStart = 1
    Out 1, 1
    AIO_Out 1, 7.5
    Speed 10
    Go XY(0.000, 0.000, 110.000, 0.0000, 0.0000, 180.0000) /1
    SpeedS 97.4
    Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
    SpeedS 57.3
    Move XY(39.882, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1 CP
    SpeedS 5.6
    Move XY(40.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
    SpeedS 45.6
    Move XY(40.000, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1
    SpeedS 57.3
    Move XY(0.118, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1 CP
    SpeedS 5.6
    Move XY(0.000, 10.000, 50.000, 0.0000, 0.0000, 180.0000) /1
    SpeedS 45.6
    Move XY(0.000, 0.000, 50.000, 0.0000, 0.0000, 180.0000) /1
  EndIf
  ' s/transfer
  SpeedS 97.4
  Move XY(0.000, 0.000, 110.000, 0.0000, 0.0000, 180.0000) /1
Fend

