"""Whether a run found on disk is the run asked for: problems and algorithms by their content.

Of both counts what they hold (by `joblib.hash`) and the code they run: `content` and `modules`. Of
a problem counts also what it computes, at a few points (`probe`): so a table that is read from a
file, or a constant that was changed in a module, shows in its values.

What cannot be known for certain (a generator, a connection, values at random) is an
`UncertainError` that says where it is. An author vouches for it by an attribute ``fingerprint``, a
text: it stands for code and values, and for attributes that cannot be told.
"""
