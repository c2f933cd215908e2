"""Folders of the problems of a study."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.studies.comparison_files import format_folder_name

ALIKE = ["a b", "a-b", "a.b", "a  b", "A b", "a b ", "a/b", "a, b", "a_b", "ab", "a\nb"]


def test_plain_labels_are_folders_as_they_are_and_others_differ():
    assert format_folder_name("attitude cubesat_6u") == "attitude-cubesat_6u"
    assert format_folder_name("dtlz2, n_obj = 3").startswith("dtlz2-n_obj-3~")
    assert format_folder_name("runs").startswith("runs~")  # the folder of the runs
    assert len({format_folder_name(label).lower() for label in ALIKE}) == len(ALIKE)


@pytest.mark.slow
@given(st.text(), st.text())
def test_folders_are_single_names_and_as_different_as_labels(a, b):
    for label in (a, b):
        name = format_folder_name(label)
        assert not set(name) & set('/\\:*?"<>|\0 ')
        assert name.strip(".") == name != ""
        assert len(name.encode()) < 255
    assert (format_folder_name(a) == format_folder_name(b)) == (a == b)
