"""Observability analysis of a plan: error budget, covariance, alternatives."""
