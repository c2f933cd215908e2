"""What of a run is kept on disk while it goes on.

`checkpoint` holds all that a run carries, so that it resumes to the same bytes; `recorder` holds
every evaluation, in the file of `record_file`.
"""
