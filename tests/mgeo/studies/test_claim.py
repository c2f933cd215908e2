"""A folder belongs to one study, which may grow."""

from pathlib import Path
from threading import Thread

import pytest
from typer.testing import CliRunner

from mgeo.cli.app import app
from mgeo.store.atomic import lock, write_files
from mgeo.studies.comparison import Comparison
from mgeo.studies.file import parse_study
from mgeo.studies.run import Failure, record
from mgeo.studies.stored import check, claim
from mgeo.studies.study import run_study

STUDY = """
title = "one"
evaluations = 40
seeds = 2
grid = 2
[[problems]]
name = "pymoo:zdt1"
options = { n_var = 4 }
[[algorithms]]
name = ["random", "nsga2"]
population = 10
"""
TWO = STUDY.replace("[[problems]]", '[[problems]]\nname = "pymoo:zdt2"\n[[problems]]')


def study(text=STUDY):
    return parse_study(text, Path())


def files(folder):
    return {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in folder.rglob("*") if p.is_file()}


def test_a_claim_waits_for_that_of_another(tmp_path):
    with lock(tmp_path):
        waiting = Thread(target=claim, args=(tmp_path, study()))
        waiting.start()
        waiting.join(0.2)
        assert waiting.is_alive()
    waiting.join()
    check(tmp_path, study())
    assert {path.name for path in tmp_path.iterdir()} == {"study.toml", "study.json"}


def test_no_other_process_writes_tables_meanwhile(tmp_path, monkeypatch):
    """Those of two studies, of other seeds say, would be mixed."""
    written = []

    def watched(folder, contents, write=write_files):
        with pytest.raises(ValueError, match="is in use"), lock(tmp_path):
            pass
        written.extend(contents)
        write(folder, contents)

    monkeypatch.setattr("mgeo.studies.study.write_files", watched)
    monkeypatch.setattr(Comparison, "figures", lambda self: {})
    run_study(study(TWO), tmp_path, progress=False)
    assert {"table.csv", "provenance.json", "summary.csv"} < set(written)


@pytest.fixture
def mgeo(tmp_path, monkeypatch, undrawn):
    monkeypatch.chdir(tmp_path)

    def command(text, *more):
        Path("study.toml").write_text(text)
        arguments = ["study", "study.toml", "--jobs", "1", "--quiet", "--out", "out", *more]
        return CliRunner().invoke(app, arguments)

    return command


@pytest.mark.slow
def test_another_study_into_one_folder_is_refused_and_changes_nothing(mgeo, tmp_path):
    assert mgeo(STUDY).exit_code == 0
    before = files(tmp_path / "out")
    for more in ([], ["--dry-run"]):
        done = mgeo(STUDY.replace("zdt1", "zdt3"), *more)
        assert done.exit_code == 2
        (line,) = done.stderr.splitlines()
        assert line.startswith(
            "Error: out belongs to another study: 'zdt1' is not among the problems; expected the "
            "problems and algorithms in its study.json"
        )
        assert files(tmp_path / "out") == before


@pytest.mark.slow
def test_the_same_study_with_more_of_it_goes_on(mgeo, tmp_path):
    assert mgeo(STUDY).exit_code == 0
    found = {path.name for path in (tmp_path / "out" / "runs").iterdir()}
    assert mgeo(STUDY, "--seeds", "3", "--evaluations", "60").exit_code == 0
    grown = STUDY.replace('title = "one"', 'title = "more of it"').replace(
        '["random", "nsga2"]', '["nsga2", "gde3", "random"]'
    )
    done = mgeo(grown)
    assert done.exit_code == 0, done.output
    # of the eight runs of both budgets none was made again, and those of GDE3 are new
    assert found < {path.name for path in (tmp_path / "out" / "runs").iterdir()}
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 4 + 6 + 2
    assert (tmp_path / "out" / "study.toml").read_text() == grown
    # now it is that of three algorithms
    assert "'gde3' is not among the algorithms" in mgeo(STUDY).stderr


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("n_var = 4", "n_var = 5", "problems.zdt1.options.n_var = 5, expected 4"),
        ("pymoo:zdt1", "zdt1", "problems.zdt1.name = 'zdt1', expected 'pymoo:zdt1'"),
        ("= 10", "= 12", "algorithms.random.parameters.population = 12, expected 10"),
        ("population = 10", "", "algorithms.random.parameters.population = None, expected 10"),
        ('"random", ', "", "'random' is not among the algorithms"),
        (STUDY, TWO, "it has one problem, whose tables are not in a folder below"),
    ],
)
def test_what_differs_is_named(old, new, message, tmp_path):
    claim(tmp_path, study())
    before = files(tmp_path)
    other = study(STUDY.replace(old, new))
    for refused in (claim, check):
        with pytest.raises(ValueError, match="belongs to another study") as caught:
            refused(tmp_path, other)
        assert message in str(caught.value)
    assert files(tmp_path) == before


@pytest.mark.slow
def test_a_study_without_tables_leaves_the_folder_to_others(mgeo, tmp_path, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr("mgeo.studies.dispatch.run", lambda task: Failure("ValueError: no"))
        assert mgeo(STUDY).exit_code == 2
    assert not (tmp_path / "out").exists()
    assert mgeo(STUDY.replace("zdt1", "zdt3")).exit_code == 0


@pytest.mark.slow
def test_who_comes_later_is_refused_though_both_began_in_an_empty_folder(tmp_path, monkeypatch):
    """Its runs are kept, as they are found by what they are."""
    made = []

    def meanwhile(task):
        if not made:
            claim(tmp_path, study(STUDY.replace("zdt1", "zdt3")))
        made.append(task)
        return record(task)

    monkeypatch.setattr("mgeo.studies.dispatch.run", meanwhile)
    with pytest.raises(ValueError, match="'zdt3' is not among the problems"):
        run_study(study(), tmp_path, progress=False)
    assert {path.name for path in tmp_path.iterdir()} == {"runs", "study.json", "study.toml"}
    assert len(list((tmp_path / "runs").iterdir())) == len(made) == 4


def test_problems_may_be_added_to_several(tmp_path):
    claim(tmp_path, study(TWO))
    claim(tmp_path, study(TWO.replace('"pymoo:zdt2"', '["pymoo:zdt2", "pymoo:zdt4"]')))
    with pytest.raises(ValueError, match="'zdt4' is not among the problems"):
        claim(tmp_path, study(TWO))


def test_what_cannot_be_told_is_refused_before_anything_is_made(tmp_path):
    odd = study(STUDY.replace("n_var = 4", "n_var = 4, x = inf"))
    with pytest.raises(ValueError, match=r"JSON cannot hold.*inf"):
        claim(tmp_path / "new", odd)
    assert not (tmp_path / "new").exists()


def test_instants_in_options_are_told_apart(tmp_path):
    """Scenarios have an epoch, and calendars of some passes."""
    dated = STUDY.replace("n_var = 4", "n_var = 4, x = { passes = [2018-06-05T00:00:00Z] }")
    claim(tmp_path, study(dated))
    claim(tmp_path, study(dated))
    assert "2018-06-05T00:00:00+00:00" in (tmp_path / "study.json").read_text()
    with pytest.raises(ValueError, match=r"passes.*2018-06-0"):
        claim(tmp_path, study(dated.replace("06-05", "06-06")))


@pytest.mark.parametrize("content", ["", "[]", '{"problems": {"a": 1}, "algorithms": {}}', "{}"])
def test_a_damaged_owner_is_named(content, tmp_path):
    (tmp_path / "study.json").write_text(content)
    with pytest.raises((ValueError, TypeError), match=r"study\.json"):
        check(tmp_path, study())
