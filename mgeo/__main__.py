"""``python -m mgeo``: the command line."""

from mgeo.cli.app import main

if __name__ == "__main__":
    main()
