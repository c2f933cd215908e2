"""Signatures of the loops: tuples of arrays that go from one to the next."""

from functools import partial

from numba import njit

#: Functions that are called, each for one signature, and kept once they are compiled.
loop = partial(njit, cache=True, error_model="numpy", nogil=True)

#: `linearization.Steps.arrays`.
MOVES = "Tuple((float64[:,:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,::1]))"
#: `linearization.Sightings.arrays`.
SIGHTS = "Tuple((float64[:,:,::1], float64[:,:,:,::1], float64[:,::1], int64[:,::1], int64[:,::1]))"
#: `smoother.Span.kept` and `readings`.
KEPT = "Tuple((float64[:,::1], float64[:,:,::1], float64[:,:,::1]))"
READINGS = "Tuple((float64[:,:,:,::1], float64[:,:,:,::1], float64[:,:,::1], float64[:,:,:,::1]))"
