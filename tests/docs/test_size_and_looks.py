"""The site stays short, and its code can be read."""

import re
from pathlib import Path

import pytest
from pygments.styles import get_style_by_name

ROOT = Path(__file__).parents[2]
#: Words of all pages but the generated reference, counted as in CONTRIBUTING.md.
MOST_WORDS = 25_000


def test_the_pages_have_at_most_so_many_words():
    pages = {
        page.relative_to(ROOT): page.read_text(encoding="utf-8")
        for page in (ROOT / "docs").rglob("*.md")
        if not {"_build", "reference"} & {*page.relative_to(ROOT).parts}
    }
    words = {str(page): len(text.split()) for page, text in pages.items()}
    assert len(words) > 20
    assert sum(words.values()) <= MOST_WORDS, sorted(words.items(), key=lambda item: -item[1])


def test_code_has_contrast():
    """At least 4.5 to 1 (WCAG AA), of every kind of token that has a color."""
    conf = (ROOT / "docs" / "conf.py").read_text(encoding="utf-8")
    (name,) = re.findall(r'^pygments_style = "(\w+)"', conf, re.M)
    style = get_style_by_name(name)
    ground = style.background_color.lstrip("#")
    found = {
        token: contrast(look["color"], ground)
        for token, look in style
        if look["color"] and "Whitespace" not in str(token)
    }
    assert len(found) > 20
    assert min(found.values()) >= 4.5, {token: c for token, c in found.items() if c < 4.5}


def contrast(color, ground):
    """Ratio of relative luminances, by WCAG 2."""
    darker, lighter = sorted(map(luminance, (color, ground)))
    return (lighter + 0.05) / (darker + 0.05)


def luminance(color):
    """Relative luminance of an sRGB color in hexadecimal digits."""
    parts = (int(color[i : i + 2], 16) / 255.0 for i in (0, 2, 4))
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_contrast_is_that_of_wcag():
    assert contrast("000000", "ffffff") == pytest.approx(21.0)
    assert contrast("777777", "ffffff") == pytest.approx(4.48, abs=0.01)
