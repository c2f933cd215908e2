"""Numba signatures of the array tuples that the compiled loops exchange."""

#: `linearization.Steps.arrays`.
MOVES = "Tuple((float64[:,:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1]))"
#: `linearization.Sightings.arrays`.
SIGHTS = "Tuple((float64[:,:,::1], float64[:,:,:,::1], float64[:,::1], int64[:,::1], int64[:,::1]))"
#: `smoother.Span.kept` and `smoother.Span.readings`.
KEPT = "Tuple((float64[:,::1], float64[:,:,::1], float64[:,:,::1]))"
READINGS = "Tuple((float64[:,:,:,::1], float64[:,:,:,::1], float64[:,:,::1], float64[:,:,:,::1]))"
