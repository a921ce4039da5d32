#include "geo/geographic.h"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Geodesic.hpp>

void geographic_forward(double a, double b, double lat_deg, double lon_deg, double height,
                        double xyz[3])
{
    GeographicLib::Geocentric(a, (a - b) / a)
        .Forward(lat_deg, lon_deg, height, xyz[0], xyz[1], xyz[2]);
}

void geographic_reverse(double a, double b, const double xyz[3], double *lat_deg, double *lon_deg,
                        double *height)
{
    GeographicLib::Geocentric(a, (a - b) / a)
        .Reverse(xyz[0], xyz[1], xyz[2], *lat_deg, *lon_deg, *height);
}

double geographic_distance(double a, double b, double lat1_deg, double lon1_deg, double lat2_deg,
                           double lon2_deg, double *azimuth1_deg, double *azimuth2_deg)
{
    double distance;
    GeographicLib::Geodesic(a, (a - b) / a)
        .Inverse(lat1_deg, lon1_deg, lat2_deg, lon2_deg, distance, *azimuth1_deg, *azimuth2_deg);
    return distance;
}
