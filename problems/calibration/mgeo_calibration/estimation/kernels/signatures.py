"""Signatures of the loops: tuples of arrays that go from one to the next."""

#: `linearization.Steps.arrays`.
MOVES = "Tuple((float64[:,:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1]))"
#: `linearization.Sightings.arrays`.
SIGHTS = "Tuple((float64[:,:,::1], float64[:,:,:,::1], float64[:,::1], int64[:,::1], int64[:,::1]))"
#: `smoother.Span.kept` and `readings`.
KEPT = "Tuple((float64[:,::1], float64[:,:,::1], float64[:,:,::1]))"
READINGS = "Tuple((float64[:,:,:,::1], float64[:,:,:,::1], float64[:,:,::1], float64[:,:,:,::1]))"
