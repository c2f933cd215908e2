"""Files of runs.

`atomic` writes files and locks folders, `reading` reads them. `run` has the data of a run,
`run_folder` its files, `study_run` the file of one run of a study, and `provenance` the identity of
a problem and the versions of the software. `checkpoint`, `recorder` and `run_persistence` save a
run while it continues.
"""
