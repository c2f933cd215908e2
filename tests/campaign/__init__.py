"""Bad input by the thousand: each case is a number, and does the same whenever it is made.

::

    python -m tests.campaign --cases 100000          progress, counts by kind, what failed
    python -m tests.campaign --case 4711 --keep      one of them again, with all it did
    python -m tests.campaign.faulty_flights          flights with a fault: is its cause named?

A case is refused with one line that gives the cause and exit code 2, or it succeeds with a sound
result; either way nothing that was there before is damaged.
"""
