// Which part of a map can be seen. Pure functions. Any thread.
#ifndef PERIGEE_RENDER_PLANAR_CULL_H
#define PERIGEE_RENDER_PLANAR_CULL_H

#include <stdbool.h>

#include "render/cells.h"

// Geodetic latitudes, and longitudes from the focus's, rad; south <= north, west <= east.
typedef struct map_rect {
    double south, north, west, east;
} map_rect;

// Smallest angle, on the unit sphere of reduced latitude, between the focus (at the view's cb, sb)
// and a point of the rectangle.
double map_rect_angle(geo_ellipsoid e, double cb, double sb, map_rect rect);

// Can terrain over the rectangle with heights in [low, high] be inside the frustum and this side
// of the horizon? Conservative: never false for what can be seen.
bool map_rect_visible(const cell_view *view, map_rect rect, double low, double high);

#endif
