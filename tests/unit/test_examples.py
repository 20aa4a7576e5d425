"""What hypothesis draws: the same in every worker and order of tests, something else by a seed."""

import importlib.util
import sys

from hypothesis import given, settings
from hypothesis import strategies as st


def examples(profile: str, number: int = 120) -> list[float | str]:
    """What one test draws under a profile of `tests/conftest.py`."""
    drawn: list[float | str] = []

    @settings(settings.get_profile(profile), max_examples=number)
    @given(st.one_of(st.floats(), st.text()))
    def any_test(value: float | str) -> None:
        drawn.append(value)

    any_test()
    return drawn


def test_modules_that_are_loaded_do_not_change_the_examples(tmp_path, monkeypatch):
    """Hypothesis would draw their constants: one example in forty is such a one."""
    before = examples("repeatable")
    file = tmp_path / "new_constants.py"
    file.write_text("\n".join(f"A{i} = {i}.125\nB{i} = 'constant {i}'" for i in range(100)))
    spec = importlib.util.spec_from_file_location("new_constants", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, "new_constants", module)

    assert list(map(repr, examples("repeatable"))) == list(map(repr, before))
