// The upward normal of the height field itself, from the gradient of its piece. Any thread, each
// with its own reader.
#ifndef PERIGEE_REFERENCE_NORMAL_H
#define PERIGEE_REFERENCE_NORMAL_H

#include "reference/ray.h"

// Unit vector, ECEF, across both tangents of P = S(lat, lon) + h n at a hit.
//   error   1e-7 against differences of positions (tests/reference/test_compare.c)
//   source  dP/dlat = (M + h) north + h_lat up, dP/dlon = (N + h) cos(lat) east + h_lon up
//   edges   on the border of two pieces that of one of them; at a pole the east slope is taken just
//           beside it
dvec3 normal_at_hit(struct field_reader *reader, const ray_hit *hit);

#endif
