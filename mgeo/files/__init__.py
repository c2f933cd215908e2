"""Files, safely: whole or not at all, and nothing believed that others wrote.

`atomic` writes, `lock` keeps a folder to one process, `reading` parses strictly, `tables` are CSV
that reads back exactly, `models` check tables of files that people write.
"""
