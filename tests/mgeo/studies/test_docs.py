"""What the page about studies shows works as it stands there."""

import re
from pathlib import Path

from mgeo.studies import read_study

PAGE = Path(__file__).parents[3] / "docs" / "studies" / "README.md"


def test_the_study_file_of_the_page_is_read(tmp_path):
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    study = read_study(tmp_path / "mine.toml")
    (problem,) = study.problems
    assert problem.label == "dtlz2 with 2 objectives"
    assert study.budget(problem.build())[0] == 20_000
    assert study.control in [algorithm.label for algorithm in study.algorithms]
