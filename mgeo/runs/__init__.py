"""Runs: prepared from names or a configuration, solved, and repeated from a saved configuration.

::

    run = prepare("attitude", algorithm="nsga2", seed=3)
    found = run.solve()
    write_run("runs/one", Run(run.configuration, found, installed_versions("attitude")))
    PreparedRun.of(read_run("runs/one").configuration).solve()  # the same front
"""
