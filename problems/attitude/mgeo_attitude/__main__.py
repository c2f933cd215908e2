"""``python -m mgeo_attitude``: the command ``mgeo-attitude``."""

from .cli import main

if __name__ == "__main__":
    main()
