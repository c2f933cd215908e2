"""Numba signatures of the array tuples that the compiled loops exchange."""

#: `kinematics.ProcessEquations.arrays`.
PROCESS = "Tuple((float64[:,:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1]))"
#: `linearization.MeasurementEquations.arrays`.
MEASUREMENTS = (
    "Tuple((float64[:,:,::1], float64[:,:,:,::1], float64[:,::1], int64[:,::1], int64[:,::1]))"
)
#: `smoother.Span.estimates` and `smoother.Span.readings`.
ESTIMATES = "Tuple((float64[:,::1], float64[:,:,::1], float64[:,:,::1]))"
READINGS = "Tuple((float64[:,:,:,::1], float64[:,:,:,::1], float64[:,:,::1], float64[:,:,:,::1]))"
