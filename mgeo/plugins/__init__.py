"""Problems and commands of others.

`discovery` finds them and says what a plugin may bring, `problems` builds a problem by its name,
`view` is what people are shown of its solutions, `protocol` and `shown` check what a problem and
its view give when they are asked, `checks` are for authors.
"""
