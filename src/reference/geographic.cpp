#include "reference/geographic.h"

#include <GeographicLib/Geocentric.hpp>

void reference_ecef(double a, double b, double lat_deg, double lon_deg, double height,
                    double xyz[3])
{
    GeographicLib::Geocentric(a, (a - b) / a)
        .Forward(lat_deg, lon_deg, height, xyz[0], xyz[1], xyz[2]);
}

void reference_geodetic(double a, double b, const double xyz[3], double *lat_deg, double *lon_deg,
                        double *height)
{
    GeographicLib::Geocentric(a, (a - b) / a)
        .Reverse(xyz[0], xyz[1], xyz[2], *lat_deg, *lon_deg, *height);
}
