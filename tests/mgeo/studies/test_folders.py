"""Folders of the problems of a study."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.studies.stored import folder_name

ALIKE = ["a b", "a-b", "a.b", "a  b", "A b", "a b ", "a/b", "a, b", "a_b", "ab", "a\nb"]


def test_plain_labels_are_folders_as_they_are_and_others_differ():
    assert folder_name("attitude cubesat_6u") == "attitude-cubesat_6u"
    assert folder_name("dtlz2, n_obj = 3").startswith("dtlz2-n_obj-3~")
    assert folder_name("runs").startswith("runs~")  # the folder of the runs
    assert len({folder_name(label).lower() for label in ALIKE}) == len(ALIKE)


@pytest.mark.slow
@given(st.text(), st.text())
def test_folders_are_single_names_and_as_different_as_labels(a, b):
    for label in (a, b):
        name = folder_name(label)
        assert not set(name) & set('/\\:*?"<>|\0 ')
        assert name.strip(".") == name != ""
        assert len(name.encode()) < 255
    assert (folder_name(a) == folder_name(b)) == (a == b)
