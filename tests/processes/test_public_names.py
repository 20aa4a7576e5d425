"""The public names that run and read experiments, used together as a newcomer would."""

from __future__ import annotations

from live_run import quick_experiment

from dubins_study import load_results, merge, render, run, status
from dubins_study.study.rows.schema import ROW, names


def test_a_small_study(tmp_path):
    """Run, ask for the state, read the judged rows, unite folders and write the page."""
    file = quick_experiment(tmp_path, 2, 'analytic", "slsqp')
    folder = run(str(file), tmp_path / "out")
    other = run(str(file), tmp_path / "other", solvers=["analytic"])

    assert (status(folder).done, status(folder).cells) == (4, 4)
    frame = load_results(folder)
    assert set(frame["verdict"]) == {"optimal"}
    assert sorted(frame["solver"]) == ["analytic", "analytic", "slsqp", "slsqp"]
    assert {"experiment", *names(ROW)} - {"versions", "machine", "run_id"} <= set(frame.columns)
    assert all(sum(lengths) > 0 for lengths in frame["lengths"])
    assert len(load_results([folder, other])) == 4
    united = merge([folder, other], tmp_path / "united")
    assert len(load_results(united.folder)) == 4
    assert render([folder]).is_file()
