"""Files of runs: atomic writing, reading, run folders, checkpoints and records of evaluations.

`atomic` writes files and locks folders, and `readers` reads files. `run` defines the data of a run,
`run_folder` its files, `solution_file` the file of one solution, and `provenance` the identity of a
problem and the versions of the software. `checkpoint` and `recorder` save a run while it continues.
"""
