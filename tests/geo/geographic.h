// GeographicLib (C++) as the oracle of the geo tests. Degrees and metres, as the library has them.
#ifndef PERIGEE_TESTS_GEOGRAPHIC_H
#define PERIGEE_TESTS_GEOGRAPHIC_H

#ifdef __cplusplus
extern "C" {
#endif

void geographic_forward(double a, double b, double lat_deg, double lon_deg, double height,
                        double xyz[3]);
void geographic_reverse(double a, double b, const double xyz[3], double *lat_deg, double *lon_deg,
                        double *height);
double geographic_distance(double a, double b, double lat1_deg, double lon1_deg, double lat2_deg,
                           double lon2_deg, double *azimuth1_deg, double *azimuth2_deg);

#ifdef __cplusplus
}
#endif

#endif
