"""Linear programs for HiGHS, by its package highspy."""

from __future__ import annotations

from typing import Any

from scipy.sparse import csr_array

from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.study.arrays import BoolArray, FloatArray


def highs_rows(
    cost: FloatArray,
    rows: csr_array,
    least: FloatArray,
    most: FloatArray,
    low: FloatArray,
    high: FloatArray,
    whole: BoolArray | None = None,
) -> Any:
    """A linear or mixed-integer program as a `highspy.HighsLp`.

    min cost x subject to least <= rows x <= most and low <= x <= high. The x with a true entry in
    `whole` are whole numbers.
    """
    import highspy

    program = highspy.HighsLp()
    program.num_col_ = cost.size
    program.num_row_ = least.size
    program.col_cost_ = cost
    program.col_lower_ = low
    program.col_upper_ = high
    program.row_lower_ = least
    program.row_upper_ = most
    matrix = program.a_matrix_
    matrix.format_ = highspy.MatrixFormat.kRowwise
    matrix.start_ = rows.indptr
    matrix.index_ = rows.indices
    matrix.value_ = rows.data
    if whole is not None:
        kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
        program.integrality_ = [kinds[is_whole] for is_whole in whole.tolist()]
    return program


def highs_holding(program: Any, options: OptionValues) -> Any:
    """A silent `highspy.Highs` that holds an unsolved program."""
    import highspy

    solver = highspy.Highs()
    solver.silent()
    for name, value in options.items():
        solver.setOptionValue(name, value)
    solver.passModel(program)
    return solver


def highs_run(program: Any, options: OptionValues) -> Any:
    """A silent `highspy.Highs` that has solved a program."""
    solver = highs_holding(program, options)
    solver.run()
    return solver
