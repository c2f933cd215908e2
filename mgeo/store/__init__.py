"""What is kept on disk, safely: whole or not at all, and nothing believed that others wrote.

`atomic` writes, `lock` keeps a folder to one process, `reading` parses strictly, `tables` are CSV
that reads back exactly. `run` is what a run says of itself, `run_folder` its files, `study_run`
that of a run of a study, `provenance` what either is from. While a run goes on, `run_persistence`
keeps all that it carries in a `checkpoint`, so that it resumes to the same bytes, and by a
`recorder` every evaluation, in a `record_file`.
"""
