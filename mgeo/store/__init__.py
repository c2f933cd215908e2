"""What is kept on disk, safely: whole or not at all, and nothing believed that others wrote.

`atomic` writes, `lock` keeps a folder to one process, `reading` parses strictly, `tables` are CSV
that reads back exactly, `models` check tables of files that people write. While a run goes on,
`checkpoint` keeps all that it carries, so that it resumes to the same bytes, and `recorder` every
evaluation, in the file of `record_file`.
"""
