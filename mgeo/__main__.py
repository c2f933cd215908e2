"""``python -m mgeo``: the command line."""

from mgeo.cli import main

if __name__ == "__main__":
    main()
