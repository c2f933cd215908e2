"""Packages to begin with: a problem of one's own, written from templates."""

from mgeo.new.problem import problem_files, write_problem

__all__ = ["problem_files", "write_problem"]
