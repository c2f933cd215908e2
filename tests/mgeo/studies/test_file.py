from pathlib import Path

import pytest

from mgeo.studies.study_file import parse_study, read_study

STUDIES = Path(__file__).parents[3] / "docs" / "studies"
SMALL = """
title = "small"
evaluations = 100
seeds = 2
[[problems]]
name = "pymoo:zdt1"
[[algorithms]]
name = "nsga2"
population = 20
"""


def parse_text(text=SMALL, folder=Path()):
    return parse_study(text, folder)


def test_small_study_has_defaults():
    study = parse_text()
    assert (study.title, study.description, study.evaluations) == ("small", "", 100)
    assert (study.seeds, study.grid, study.published) == ((1, 2), 50, None)
    (problem,), (algorithm,) = study.problems, study.algorithms
    assert (problem.label, problem.build().n_var) == ("zdt1", 30)
    assert (algorithm.label, algorithm.name) == ("nsga2", "nsga2")
    assert algorithm.build(problem.build()).pop_size == 20


def test_lists_of_values_define_one_algorithm_per_combination():
    study = parse_text(
        SMALL.replace('name = "nsga2"', 'name = ["nsga2", "gde3"]').replace("= 20", "= [20, 30]")
    )
    assert [(c.label, c.parameters["population"]) for c in study.algorithms] == [
        ("nsga2, population = 20", 20),
        ("nsga2, population = 30", 30),
        ("gde3, population = 20", 20),
        ("gde3, population = 30", 30),
    ]


def test_scenarios_of_installed_problem_are_presets_or_files(stand_in, tmp_path):
    (tmp_path / "mine.toml").write_text("load = 3.5")
    table = 'name = "cantilever"\nscenario = ["heavy", "mine.toml"]\nlabel = "{scenario} {name}"'
    study = parse_text(SMALL.replace('name = "pymoo:zdt1"', table), tmp_path)
    assert [p.label for p in study.problems] == ["heavy cantilever", "mine cantilever"]
    assert [p.build().load for p in study.problems] == [2000.0, 3.5]


def test_equal_labels_of_problems_are_rejected():
    two = 'name = "pymoo:dtlz2"\noptions = { n_obj = 2 }\n'
    three = two.replace("2 }", '3 }\nlabel = "{name} {n_obj}D"')
    study = parse_text(SMALL.replace('name = "pymoo:zdt1"', f"{two}[[problems]]\n{three}"))
    assert [p.label for p in study.problems] == ["dtlz2", "dtlz2 3D"]
    assert [p.build().n_obj for p in study.problems] == [2, 3]
    message = r"problems: the label 'dtlz2' occurs twice; set different labels with the key label"
    with pytest.raises(ValueError, match=message):
        parse_text(SMALL.replace('name = "pymoo:zdt1"', f"{two}[[problems]]\n{two}"))


def test_budget_and_seeds_can_be_changed():
    study = parse_text(SMALL.replace("seeds = 2", "seeds = [4, 9]"))
    assert study.with_budget(50, 1).seeds == (4,)
    assert study.with_budget(50, 1).evaluations == 50
    assert study.with_budget(seeds=4).seeds == (4, 9, 10, 11)
    assert study.with_budget() == study
    with pytest.raises(ValueError, match="seeds = 0"):
        study.with_budget(seeds=0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('title = "small"', "", "title is missing"),
        ("seeds = 2", "seeds = 2\ngrid = [0]", r"grid\[0\] = 0: expected an integer"),
        ("seeds = 2", "seeds = [1, 1]", r"seeds = \[1, 1\]: expected one or more different"),
        (
            'name = "pymoo:zdt1"',
            'name = "a"\nscenario = "b"\noptions = {}',
            "expected only one of them",
        ),
        (
            "population = 20",
            'label = "{size}"',
            r"label = '\{size\}': expected only name in braces",
        ),
        (
            "population = 20",
            "[published]\nsource = 'a'\ntable = { b = { points = 3 } }",
            "'b' is not an algorithm of this study: expected one of nsga2",
        ),
        ("seeds = 2", "seeds = 2\ncontrol = 'b'", "control: 'b' is not an algorithm of this study"),
        ("seeds = 2", "seeds = ", "Invalid value"),
    ],
)
def test_error_message_names_file_and_key(old, new, message, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(SMALL.replace(old, new))
    with pytest.raises((ValueError, TypeError), match=message) as caught:
        read_study(path)
    assert str(caught.value).startswith(str(path))


def test_budget_per_variable_scales_with_problem_size():
    text = SMALL.replace("seeds = 2", "seeds = 2\nper_variable = true\ngrid = [10, 50, 100]")
    study = parse_text(text.replace('"pymoo:zdt1"', '["pymoo:zdt1", "pymoo:zdt4"]'))
    budgets = [study.compute_budget(problem.build()) for problem in study.problems]
    assert budgets == [(3000, [300, 1500, 3000]), (1000, [100, 500, 1000])]
    assert study.with_budget(60).compute_budget(study.problems[1].build()) == (600, [100, 500])
    absolute = parse_text(SMALL.replace("seeds = 2", "seeds = 2\ngrid = 4"))
    assert absolute.compute_budget(absolute.problems[0].build()) == (100, 4)


@pytest.mark.parametrize("name", [path.stem for path in sorted(STUDIES.glob("*.toml"))])
def test_published_studies_can_be_built(name):
    if name in ("table3", "tuning", "comparison", "budgets", "robust", "held-out", "propellant"):
        pytest.importorskip("mgeo_attitude")
    study = read_study(STUDIES / f"{name}.toml")
    for configuration in study.problems[:: max(1, len(study.problems) - 1)]:
        problem = configuration.build()
        for algorithm in study.algorithms:
            algorithm.build(problem)


def test_list_valued_parameter_is_written_as_list_in_list():
    prefix = SMALL + '[[algorithms]]\nname = "mgeo-directed"\nmomentum = '
    study = parse_text(prefix + "[[0.6, 0.4]]")
    (problem,) = (configuration.build() for configuration in study.problems)
    assert study.algorithms[-1].build(problem).momentum == [0.6, 0.4]
    first, second = parse_text(prefix + "[0.6, 0.4]").algorithms[1:]
    for configuration, value in ((first, 0.6), (second, 0.4)):
        message = f"mgeo-directed, momentum = {value}: momentum = {value}: expected two numbers"
        with pytest.raises(ValueError, match=message):
            configuration.build(problem)
