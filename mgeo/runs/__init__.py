"""Single runs of an algorithm: preparation, execution, local refinement and summary.

::

    run = prepare_run("attitude", algorithm="nsga2", seed=3)
    outcome = run.solve()
    versions = list_problem_versions("attitude")
    write_run("runs/one", Run(run.configuration, outcome, versions))
    PreparedRun.from_configuration(read_run("runs/one").configuration).solve()  # equal front
"""
