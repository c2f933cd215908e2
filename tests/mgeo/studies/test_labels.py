import pytest
from hypothesis import given
from hypothesis import strategies as st

from mgeo.studies.labels import filled, folder_name

ALIKE = ["a b", "a-b", "a.b", "a  b", "A b", "a b ", "a/b", "a, b", "a_b", "ab", "a\nb"]


def test_plain_labels_are_folders_as_they_are():
    assert folder_name("zdt1") == "zdt1"
    assert folder_name("attitude cubesat_6u") == "attitude-cubesat_6u"


def test_folders_of_labels_that_look_alike_differ():
    assert len({folder_name(label) for label in ALIKE}) == len(ALIKE)
    assert len({folder_name(label).lower() for label in ALIKE}) == len(ALIKE)
    assert folder_name("a.b") == "a-b~" + folder_name("a.b")[-8:]
    assert folder_name("dtlz2, n_obj = 3").startswith("dtlz2-n_obj-3~")


@pytest.mark.slow
@given(st.text(), st.text())
def test_folders_are_single_names_and_as_different_as_labels(a, b):
    for label in (a, b):
        name = folder_name(label)
        assert not set(name) & set('/\\:*?"<>|\0 ')
        assert name.strip(".") == name != ""
        assert len(name.encode()) < 255
    assert (folder_name(a) == folder_name(b)) == (a == b)


def test_no_label_takes_the_folder_of_the_runs():
    assert folder_name("runs").startswith("runs~")
    assert folder_name("").startswith("problem~")


def test_braces_are_filled():
    label = "{name}, {n_obj} objectives"
    assert filled(label, "problems[0].", {"name": "x", "n_obj": 3}) == "x, 3 objectives"
    with pytest.raises(ValueError, match=r"problems\[0\].label = .*braces hold only name$"):
        filled(label, "problems[0].", {"name": "x"})
