"""The installed package beside a user's own modules.

They have the names `study`, `solvers`, ...
"""

import os
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.plugin_files import copied

ROOT = Path(__file__).parents[2]
EDITABLE = "from hatchling.build import build_editable; build_editable({folder!r})"
EXPERIMENT = """
title = "beside"
question = "is it found?"
solvers = ["analytic", "slsqp", "./beside_modules.py:Plugin"]
[[scenarios]]
target_x = [2, 3]
target_y = 1
"""
SCRIPT = """
import os, sys
import dubins_study
from pathlib import Path
assert str(Path(sys.prefix).resolve()) in str(Path(dubins_study.__file__).resolve())
for name in dubins_study.__all__:
    assert getattr(dubins_study, name) is not None
folder = dubins_study.run("beside.toml", "by-script", solvers=["analytic", "slsqp"])
page = dubins_study.render([folder])
assert page.is_file()
assert dubins_study.solve(dubins_study.Scenario(0, 0, 0, 3, 1, 1)).verdict == "optimal"
"""
NAMES = ("study.py", "report.py", "solvers/__init__.py", "experiments/__init__.py")


def called(*arguments: object, cwd: Path = ROOT) -> str:
    """Standard output of a command that must succeed.

    It runs without the caller's PYTHONPATH.
    """
    environment = os.environ | {"PYTHONPATH": ""}
    line = [*map(str, arguments)]
    done = subprocess.run(line, capture_output=True, text=True, cwd=cwd, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def at_the_top(names: list[str]) -> set[str]:
    return {name.split("/")[0] for name in names}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with both distributions of this checkout.

    They are the wheel and the source distribution.
    """
    folder = tmp_path_factory.mktemp("built")
    called(sys.executable, "-m", "hatchling", "build", "-d", folder)
    return folder


def wheel_in(folder: Path) -> Path:
    (wheel,) = folder.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def user(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's folder.

    It has an environment with the wheel, and modules of the names of our rooms.
    """
    folder = tmp_path_factory.mktemp("user")
    venv.create(folder / "env", with_pip=True)
    site = next((folder / "env").glob("lib/python*/site-packages"))
    before = {entry.name for entry in site.iterdir()}
    pip = (folder / "env" / "bin" / "python", "-m", "pip", "--disable-pip-version-check")
    called(*pip, "install", "--quiet", "--no-index", "--no-deps", wheel_in(built))
    new = {entry.name for entry in site.iterdir()} - before
    assert {name for name in new if not name.endswith(".dist-info")} == {"dubins_study"}
    # the libraries that the tests run with, without the editable installation among them
    (site / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")
    for name in NAMES:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(f"raise SystemError('the module {name} of the user')\n")
    copied("beside_modules", folder)
    (folder / "beside.toml").write_text(EXPERIMENT)
    (folder / "script.py").write_text(SCRIPT)
    return folder


@pytest.mark.slow
def test_nothing_else_is_packaged(built, tmp_path):
    """Nothing else is packaged.

    That holds for the wheel, for what an editable installation adds, and for a wheel of the source
    distribution, in which the links at the top are missing.
    """
    names = zipfile.ZipFile(wheel_in(built)).namelist()
    called(sys.executable, "-c", EDITABLE.format(folder=str(tmp_path)))
    with zipfile.ZipFile(wheel_in(tmp_path)) as editable:
        (pth,) = {n for n in editable.namelist() if "/" not in n and n.endswith(".pth")}
        source = Path(editable.read(pth).decode().strip())
        others = at_the_top(editable.namelist()) - {pth}
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as unpacked:
        unpacked.extractall(tmp_path / "sdist", filter="data")
    (copy,) = (tmp_path / "sdist").iterdir()
    called(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", copy / "new", cwd=copy)

    assert {n.removesuffix(".dist-info") for n in at_the_top(names)} == {
        "dubins_study",
        wheel_in(built).name.rsplit("-", 3)[0],
    }
    assert {p.name for p in source.iterdir() if p.suffix != ".egg-info"} == {"dubins_study"}
    assert all(name.endswith(".dist-info") for name in others)
    assert {p.name for p in copy.iterdir()}.isdisjoint({"study", "solvers", "report"})
    assert sorted(zipfile.ZipFile(wheel_in(copy / "new")).namelist()) == sorted(names)


@pytest.mark.slow
def test_the_public_names_in_a_script_beside_them(user):
    """The public names work in a script beside them.

    A script's own folder is first on its path: every public name, workers and page are used.
    """
    called(user / "env" / "bin" / "python", "script.py", cwd=user)


@pytest.mark.slow
def test_the_command_beside_them(user):
    """The command works beside them.

    It runs with worker processes and a plug-in, report and status; `-m` puts the folder on the
    path, which no worker inherits.
    """
    program = user / "env" / "bin" / "dubins-study"
    out = user / "by-command"
    module = (user / "env" / "bin" / "python", "-m", "dubins_study")
    text = called(program, "solve", 10, 5, "--json", cwd=user)
    called(*module, "run", "beside.toml", "--out", out, "--trust-plugins", cwd=user)
    called(program, "report", out, cwd=user)

    assert '"word"' in text
    assert (out / "report" / "index.html").is_file()
    assert "6" in called(*module, "status", out, cwd=user)
    verdicts = pq.read_table(out / "parts")["verdict"].to_pylist()
    assert verdicts == ["optimal"] * 6
