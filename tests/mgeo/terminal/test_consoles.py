"""Text that is broken for a terminal."""

from mgeo.terminal import broken, plain


def test_text_is_broken_between_words_and_goes_on_indented():
    text = plain(
        "  relax wheel momentum from 1 to 2 N m s\nwritten: runs/a-long-path/front.html", "bold"
    )
    found = broken(text, 24)
    assert found.plain.splitlines() == [
        "  relax wheel momentum",
        "    from 1 to 2 N m s",
        "written:",
        "  runs/a-long-path/front.html",  # a path stays whole
    ]
    assert found.style == "bold"
    assert broken(plain("a\n\nb"), 24).plain == "a\n\nb"
