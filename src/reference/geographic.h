// Conversions by GeographicLib, so that the reference shares no arithmetic with src/geo. Degrees
// and metres. Any thread.
#ifndef PERIGEE_REFERENCE_GEOGRAPHIC_H
#define PERIGEE_REFERENCE_GEOGRAPHIC_H

#ifdef __cplusplus
extern "C" {
#endif

void reference_ecef(double a, double b, double lat_deg, double lon_deg, double height,
                    double xyz[3]);
void reference_geodetic(double a, double b, const double xyz[3], double *lat_deg, double *lon_deg,
                        double *height);

#ifdef __cplusplus
}
#endif

#endif
