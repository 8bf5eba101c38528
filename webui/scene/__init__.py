"""The 3-D scene: camera, light, picking, and what is shown of nozzle and robot."""
