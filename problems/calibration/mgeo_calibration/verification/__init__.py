"""Whether a plan achieves what its covariance promises."""

from mgeo_calibration.verification.remedies import conclusion, findings, power, remedies
from mgeo_calibration.verification.verification import LEVEL, Verification, verify

__all__ = ["LEVEL", "Verification", "conclusion", "findings", "power", "remedies", "verify"]
