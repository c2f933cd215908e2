"""Function that installs a distribution for a test."""


def claim(folder, distribution, name, value="stand_in:Cantilever", group="mgeo.problems"):
    """Write the metadata of a distribution with one entry point to a folder."""
    info = folder / f"{distribution}-2.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{name} = {value}\n")
