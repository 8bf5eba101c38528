"""The thread of a URScript program that switches outputs on the path."""

QUEUE = 16
"""Outputs that may wait at once: those of a line, and the last of the line before, whose blend has begun."""
KINDS = {"digital": 0, "group": 1, "analog": 2}
"""How ``set_out`` and ``arm`` name the kind of an output."""

EXPLANATIONS = (
    "movel rather than movep: it blends with the moves before and after, reaches the same speed on a straight line,",
    "and takes a time where the tool only turns. The speed slider has to stand at 100 %: outputs are at places.",
)

WATCHER = f"""\
# Outputs on the path. A move with outputs is preceded by one arm() for each: from, to, metres from the start, kind and
# number of the output, value. The thread compares the way done with the places 500 times a second, in their order.
global ev_x = {[0.0] * QUEUE}
global ev_y = {[0.0] * QUEUE}
global ev_z = {[0.0] * QUEUE}
global ev_u = {[0.0] * QUEUE}
global ev_v = {[0.0] * QUEUE}
global ev_w = {[0.0] * QUEUE}
global ev_way = {[0.0] * QUEUE}
global ev_kind = {[0] * QUEUE}
global ev_number = {[0] * QUEUE}
global ev_value = {[0.0] * QUEUE}
global ev_armed = 0
global ev_done = 0
global board = p[0,0,0,0,0,0]
def set_out(kind, number, value):
  if kind == 0:
    set_standard_digital_out(number, value > 0.5)
  elif kind == 1:
    write_output_integer_register(number, floor(value + 0.5))
  else:
    set_standard_analog_out(number, value)
  end
end
def arm(start, target, way, kind, number, value):
  local length = point_dist(start, target)
  local i = ev_armed % {QUEUE}
  ev_x[i] = start[0]
  ev_y[i] = start[1]
  ev_z[i] = start[2]
  ev_u[i] = (target[0]-start[0])/length
  ev_v[i] = (target[1]-start[1])/length
  ev_w[i] = (target[2]-start[2])/length
  ev_way[i] = way
  ev_kind[i] = kind
  ev_number[i] = number
  ev_value[i] = value
  ev_armed = ev_armed + 1
end
def fire():
  local i = ev_done % {QUEUE}
  set_out(ev_kind[i], ev_number[i], ev_value[i])
  ev_done = ev_done + 1
end
thread watch():
  while True:
    enter_critical
    if ev_done < ev_armed:
      local i = ev_done % {QUEUE}
      local at = pose_trans(pose_inv(board), get_target_tcp_pose())
      local way = (at[0]-ev_x[i])*ev_u[i] + (at[1]-ev_y[i])*ev_v[i] + (at[2]-ev_z[i])*ev_w[i]
      if way > ev_way[i] - 0.00001:
        fire()
      end
    end
    exit_critical
    sync()
  end
end
# After a stop nothing may be left to switch.
def settle():
  enter_critical
  while ev_done < ev_armed:
    fire()
  end
  exit_critical
end
""".splitlines()
