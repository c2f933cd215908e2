"""Display of maneuver plans: tables, summaries, warnings and figures for the command line and
reports.
"""
