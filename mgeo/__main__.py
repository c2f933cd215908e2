"""The command ``mgeo``, also as ``python -m mgeo``."""

import gc
import sys


def main() -> None:
    """Run the command, or print what to install where its libraries are missing."""
    # what imports allocate stays: looking for garbage in it takes a fifth of a short command
    gc.set_threshold(100_000)
    try:
        from mgeo.cli.app import main as run
    except ModuleNotFoundError as error:
        if (error.name or "mgeo").partition(".")[0] == "mgeo":
            raise
        sys.exit(f"Error: no module {error.name}: the command needs pip install 'mgeo[cli]'")
    run()


if __name__ == "__main__":
    main()
