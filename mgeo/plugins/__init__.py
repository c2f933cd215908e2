"""Problems and commands of others.

`discovery` finds them and says what a plugin may bring, `protocol` checks what a problem gives when
it is asked, `identity` says which problem is meant, and `checks`, for which the public name is
`mgeo.testing`, are what a plugin runs on itself.
"""
