"""Entry point of the command ``mgeo`` and of ``python -m mgeo``."""

import gc
import sys


def main() -> None:
    """Run the command ``mgeo``, or exit with an installation hint if a library is missing."""
    # Objects that imports create are never garbage. Checking them takes 20 % of the time of a short
    # command.
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
