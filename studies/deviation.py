"""A program and a recipe as they are carried out with deviations of standoff, place, pressure, temperature and wear."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from boards.board import Board
from programs.program import Command, Instruction, MoveTo, TimedProgram
from recipes.recipe import Recipe
from studies.design import Deviation
from studies.study import Quantity

_PRESSURE, _TEMPERATURE = "pressure_bar", "temperature_c"


def deviate(program: TimedProgram, recipe: Recipe, board: Board, deviation: Deviation) -> tuple[TimedProgram, Recipe]:
    """Give the program as it meets a displaced board, and the recipe with the pressure, flow and warmth there is.

    The program keeps its times. Liquid goes with the square root of the pressure, as in planning, and with the wear.
    """
    of = dict(deviation)
    pressure = 1.0 + of.get("pressure_pct", 0.0) / 100.0
    flow = 1.0 + of.get("nozzle_wear_pct", 0.0) / 100.0
    warmer = of.get("temperature_c", 0.0)
    instructions = tuple(_set(each, pressure, warmer) for each in _moved(program, board, of))
    litres = tuple((name, amount * flow * math.sqrt(pressure)) for name, amount in program.totals.liquid_l)
    functions = {
        name: each.model_copy(
            update={
                _PRESSURE: each.pressure_bar * pressure,
                _TEMPERATURE: None if each.temperature_c is None else each.temperature_c + warmer,
            }
        )
        for name, each in recipe.functions.items()
    }
    nozzles = {
        name: each.model_copy(update={"flow_lpm": each.flow_lpm * flow}) for name, each in recipe.nozzles.items()
    }
    done = replace(program, instructions=instructions, totals=replace(program.totals, liquid_l=litres))
    return done, recipe.model_copy(update={"functions": functions, "nozzles": nozzles})


def _moved(program: TimedProgram, board: Board, of: Mapping[Quantity, float]) -> list[Instruction]:
    """Move the orifice back along its jet, and look at it from the board that is displaced."""
    instructions = list(program.instructions)
    rows = [row for row, each in enumerate(instructions) if isinstance(each, MoveTo)]
    moves = [each for each in instructions if isinstance(each, MoveTo)]
    if not moves:
        return instructions
    turned = Rotation.from_quat([each.quaternion for each in moves], scalar_first=True)
    places = np.array([each.position for each in moves])
    places -= of.get("standoff_mm", 0.0) * turned.apply([0.0, 0.0, 1.0])
    left, front, right, back = board.outline.bounds
    centre = np.array([0.5 * (left + right), 0.5 * (front + back), 0.0])
    back_turn = Rotation.from_euler("z", -of.get("turn_deg", 0.0), degrees=True)
    shift = np.array([of.get("shift_x_mm", 0.0), of.get("shift_y_mm", 0.0), 0.0])
    places = back_turn.apply(places - shift - centre) + centre
    poses = (back_turn * turned).as_quat(scalar_first=True)
    for row, each, place, pose in zip(rows, moves, places.tolist(), poses.tolist(), strict=True):
        instructions[row] = replace(each, position=(place[0], place[1], place[2]), quaternion=tuple(pose))
    return instructions


def _set(instruction: Instruction, pressure: float, warmer: float) -> Instruction:
    """Change the pressure and the temperature that a program sets."""
    if not (isinstance(instruction, Command) and instruction.keyword == "SET"):
        return instruction
    key, value = instruction.arguments[0], instruction.arguments[1]
    if key == _PRESSURE:
        return replace(instruction, arguments=(key, f"{float(value) * pressure:.6g}"))
    return replace(instruction, arguments=(key, f"{float(value) + warmer:.6g}")) if key == _TEMPERATURE else instruction
