// Where the sun stands. Uses libnova. Any thread.
#ifndef PERIGEE_GEO_SUN_H
#define PERIGEE_GEO_SUN_H

#include "base/vec.h"

// Unit vector towards the sun in ECEF at a UTC time (seconds since 1970-01-01T00:00Z).
dvec3 geo_sun_direction(double unix_time_s);

// Parses "YYYY-MM-DDTHH:MM[:SS][Z]" as UTC seconds since 1970. Returns 0, or -1 when it is not such
// a time.
int geo_time_parse(const char *text, double *unix_time_s);

#endif
