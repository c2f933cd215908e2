"""The example package of a page, written to files with the metadata that pip would write."""

import re
import sys
import tomllib
from pathlib import Path

#: A file name, text, and a block with the content of the file.
_FILE = re.compile(r"`([\w/]+\.(?:py|toml))`[^`]*(?:`[^`\n]+`[^`]*)*```\w+\n(.*?)```", re.DOTALL)


def install_package(page: str, folder: Path) -> None:
    """Write the files of a page, and let this process and its commands import the package."""
    files = dict(_FILE.findall(page))
    project = tomllib.loads(files["pyproject.toml"])["project"]
    info = f"{project['name']}-{project['version']}.dist-info"
    head = "Metadata-Version: 2.1\nName: {name}\nVersion: {version}\nSummary: {description}\n"
    files[f"{info}/METADATA"] = head.format_map(project)
    files[f"{info}/entry_points.txt"] = "".join(
        f"[{group}]\n{name} = {value}\n"
        for group, entries in project["entry-points"].items()
        for name, value in entries.items()
    )
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    sys.path.insert(0, str(folder))
