"""Store the results of a study in a small form, next to its page in the repository.

    python docs/studies/store.py studies/table3
    python docs/studies/store.py studies/tuning --no-fronts
    python docs/studies/store.py studies/bbob-biobj --no-problems
    python docs/studies/store.py studies/coco-data/mgeo_directed --coco

The script reads a folder that ``mgeo study`` wrote, and writes the files that
`mgeo.studies.read_comparison` needs to ``docs/studies/data/NAME``, with a subfolder per problem if
there are several. Numbers are rounded to six digits. The front of the median run of each algorithm
is stored completely, and the fronts of its other runs are truncated. With ``--no-problems``, only
values, ranks and targets over all problems are stored. With ``--coco``, the data of COCO's observer
are stored in an archive that ``cocopp`` reads.
"""

import argparse
import json
import shutil
import tarfile
from dataclasses import replace
from pathlib import Path

import pandas as pd

from mgeo.algorithms.archive import truncate
from mgeo.store.atomic import write_files
from mgeo.studies import Comparison, read_comparison
from mgeo.studies.comparison_files import FRONTS_FILE, PROVENANCE_FILE, RUNS_FILE, TABLE_FILE
from mgeo.studies.study import RANKS_FILE, TARGETS_FILE, VALUES_FILE

DATA = Path(__file__).parent / "data"
DIGITS = 6
POINTS = 40  # Number of points of a truncated front.


def store_pooled(source: Path, target: Path) -> list[Path]:
    """Store values, ranks, targets and the provenance of the first problem; return the files."""
    first = min(source.glob(f"*/{PROVENANCE_FILE}"))
    target.mkdir(parents=True, exist_ok=True)
    write_files(target, {VALUES_FILE: _csv(pd.read_csv(source / VALUES_FILE))})
    return [target / VALUES_FILE] + [
        Path(shutil.copyfile(path, target / path.name))
        for path in (source / RANKS_FILE, source / TARGETS_FILE, first)
    ]


def store(source: Path, target: Path, fronts: bool = True) -> list[Path]:
    """Store the small form of every comparison in a folder, and return the written folders.

    Raises
    ------
    FileNotFoundError
        If the folder contains no comparison.
    """
    sources = sorted(path.parent for path in source.glob(f"**/{PROVENANCE_FILE}"))
    if not sources:
        raise FileNotFoundError(f"{source} holds no comparison: there is no {PROVENANCE_FILE}")
    written = []
    for folder in sources:
        contents = small_tables(read_comparison(folder), fronts)
        data = json.loads((folder / PROVENANCE_FILE).read_text(encoding="utf-8"))
        data["kept"] = {"digits": DIGITS, "points_of_other_fronts": POINTS if fronts else 0}
        contents[PROVENANCE_FILE] = (json.dumps(data, indent=2) + "\n").encode()
        place = target / folder.relative_to(source)
        place.mkdir(parents=True, exist_ok=True)
        write_files(place, contents)
        written.append(place)
    return written


def store_coco(source: Path, target: Path) -> Path:
    """Store the files that ``cocopp`` reads in an archive, and return its path.

    Data on restarts and recommendations are left out.
    """
    # Files of the same kind are similar, so that they are compressed better in sequence.
    files = [path for end in (".info", ".dat", ".tdat") for path in sorted(source.rglob(f"*{end}"))]
    if not files:
        raise FileNotFoundError(f"{source} holds no data of COCO's observer: there is no .info")
    archive = target / f"{source.name}.tar.xz"
    with tarfile.open(archive, "w:xz", preset=9) as kept:
        for path in files:
            entry = tarfile.TarInfo(str(path.relative_to(source.parent)))
            entry.size = path.stat().st_size
            with path.open("rb") as content:
                kept.addfile(entry, content)
    return archive


def small_tables(comparison: Comparison, fronts: bool = True) -> dict[str, bytes]:
    """Return the content of each table file of a comparison, with rounded numbers."""
    contents = {TABLE_FILE: _csv(comparison.table), RUNS_FILE: _csv(comparison.runs)}
    if fronts:
        contents[FRONTS_FILE] = _csv(_fronts(comparison))
    return contents


def _fronts(comparison: Comparison) -> pd.DataFrame:
    rounded = comparison.table.map(lambda v: float(_text(v)) if isinstance(v, float) else v)
    median = {
        n: replace(comparison, table=rounded).find_median_seed(n) for n in comparison.algorithms
    }
    tables = []
    for (name, seed), record in comparison.finished_runs.items():
        F = record.front_F
        if seed != median[name]:
            F = F[truncate(F, POINTS)]
        front = pd.DataFrame(F, columns=list(comparison.objectives))
        front.insert(0, "algorithm", name)
        front.insert(1, "seed", seed)
        tables.append(front)
    return pd.concat(tables)


def _csv(table: pd.DataFrame) -> bytes:
    text: str = table.to_csv(index=False, na_rep="nan", lineterminator="\n", float_format=_text)
    return text.encode()


def _text(value: float) -> str:
    return f"{value:.{DIGITS}g}"


def main() -> None:
    parser = argparse.ArgumentParser(description="Keep the results of a study beside its page.")
    parser.add_argument("folder", type=Path, help="what `mgeo study` wrote: studies/NAME")
    parser.add_argument("--no-fronts", action="store_true", help="keep tables only")
    parser.add_argument("--no-problems", action="store_true", help="keep what is pooled only")
    parser.add_argument("--coco", action="store_true", help="what coco_data.py wrote instead")
    given = parser.parse_args()
    target = DATA / given.folder.name
    if given.coco:
        places = [store_coco(given.folder, DATA / "coco")]
    elif given.no_problems:
        places = store_pooled(given.folder, target)
    else:
        places = store(given.folder, target, not given.no_fronts)
    for place in places:
        print(place)


if __name__ == "__main__":
    main()
