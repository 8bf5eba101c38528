"""What a process engineer asks for: functions, nozzles, classes, masks, templates, sequence."""
