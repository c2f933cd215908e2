"""Files of runs.

`atomic` writes files and locks folders, `reading` reads them. `run` has the data of a run,
`run_folder` its files, `solution_file` the file of one solution, and `provenance` the identity of a
problem and the versions of the software. `checkpoint` and `recorder` save a run while it continues.
"""
