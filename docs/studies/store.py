"""Keeps what a study found beside its page, small enough for a repository.

    python docs/studies/store.py studies/table3
    python docs/studies/store.py studies/tuning --no-fronts
    python docs/studies/store.py studies/bbob-biobj --no-problems
    python docs/studies/store.py studies/coco-data/mgeo_directed --coco

Of the folder that ``mgeo study`` wrote, what `mgeo.studies.read_comparison` needs goes into
``docs/studies/data/NAME``, a folder each below it where there are several problems: numbers to six
digits, the front of each algorithm's median run whole, those of its other runs truncated. Of many
problems only what is pooled over them may be kept: values, ranks and targets. Of what COCO's
observer logged of an algorithm an archive is kept, which ``cocopp`` reads.
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
POINTS = 40  # of a front that is not the median one


def store_pooled(source: Path, target: Path) -> list[Path]:
    """Keep values, ranks, targets, and the provenance of the first problem."""
    first = min(source.glob(f"*/{PROVENANCE_FILE}"))
    target.mkdir(parents=True, exist_ok=True)
    write_files(target, {VALUES_FILE: _csv(pd.read_csv(source / VALUES_FILE))})
    return [target / VALUES_FILE] + [
        Path(shutil.copyfile(path, target / path.name))
        for path in (source / RANKS_FILE, source / TARGETS_FILE, first)
    ]


def store(source: Path, target: Path, fronts: bool = True) -> list[Path]:
    """Write the small form of every comparison in `source`; the folders written.

    Raises
    ------
    FileNotFoundError
        If there is none.
    """
    found = sorted(path.parent for path in source.glob(f"**/{PROVENANCE_FILE}"))
    if not found:
        raise FileNotFoundError(f"{source} holds no comparison: there is no {PROVENANCE_FILE}")
    written = []
    for folder in found:
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
    """Keep what ``cocopp`` reads of an algorithm's runs: not restarts and recommendations."""
    # of one kind after the other, as they are alike
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
    """The tables of a comparison, by file."""
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
