"""Files that the server has: the page, its scripts, and how a browser is to treat them."""

from __future__ import annotations

from plotly.offline import get_plotlyjs

from mgeo.figures.page import render

#: Nothing from elsewhere; plotly's three-dimensional figures compile functions.
_POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self'; img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
SECURITY = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_SCRIPTS = ("figures/assets/theme", "report/assets/figures", "report/assets/motion")
_OWN = ("parallel", "scatter", "solution", "explore")


def assets(title: str) -> dict[str, tuple[str, bytes]]:
    """Content type and content of each file, by its path below the token."""
    names = [*_SCRIPTS, *(f"explore/assets/{name}" for name in _OWN)]
    script = "\n".join(render(f"{name}.js") for name in names)
    html = render("explore/assets/explore.html", title=title)
    return {
        "": ("text/html; charset=utf-8", html.encode()),
        "explore.js": ("text/javascript; charset=utf-8", script.encode()),
        "plotly.js": ("text/javascript; charset=utf-8", get_plotlyjs().encode()),
    }
