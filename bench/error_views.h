// The views at which the frame's error is measured: space, air and ground; equator, middle and high
// latitudes, poles; mountains, coast, ocean; straight down, to the horizon, through a telephoto.
// Heights are above the ground. 90 degrees unless said.
#ifndef PERIGEE_BENCH_ERROR_VIEWS_H
#define PERIGEE_BENCH_ERROR_VIEWS_H

struct error_view {
    const char *name;
    double lat_deg, lon_deg, above_m, heading_deg, pitch_deg, fov_deg;
};

static const struct error_view ERROR_VIEWS[] = {
    {"space, equator", 0, 20, 1.2e7, 0, -90, 90},
    {"space, pole", 90, 0, 8e6, 0, -90, 90},
    {"orbit, Himalaya", 28, 86.9, 4e5, 0, -90, 90},
    {"orbit, limb, Andes", -20, -66, 4e5, 250, -20, 90},
    {"orbit, limb, Greenland", 72, -40, 8e5, 20, -35, 90},
    {"high, Korea, down", 37, 128.2, 1e5, 0, -90, 90},
    {"high, Antarctica", -80, 160, 6e4, 180, -25, 90},
    {"high, coast of Chile", -33, -72, 5e4, 90, -20, 90},
    {"air, Korea, horizon", 37.6, 128.2, 1e4, 45, -15, 90},
    {"air, Korea, down", 38.1, 128.4, 1e4, 0, -90, 90},
    {"air, Everest", 27.7, 86.7, 1e4, 40, -15, 90},
    {"air, Oetztal", 46.9, 10.9, 5e3, 200, -20, 90},
    {"air, Rainier", 46.6, -121.9, 5e3, 30, -15, 90},
    {"air, north pole", 90, 0, 1e4, 30, -20, 90},
    {"air, south pole", -90, 0, 1e4, 200, -20, 90},
    {"air, near the pole", -89.97, 70, 3e3, 120, -15, 90},
    {"air, equator, Kilimanjaro", -2.9, 37.0, 6e3, 150, -10, 90},
    {"air, ocean", -10, -150, 5e3, 0, -10, 90},
    {"air, antimeridian, Fiji", -17, 180, 8e3, 330, -15, 90},
    {"low, Korea", 38.0, 128.3, 1e3, 60, -10, 90},
    {"low, coast of Korea", 37.8, 128.9, 1e3, 270, -10, 90},
    {"low, Everest", 27.9, 86.8, 1e3, 60, 0, 90},
    {"ground, Korea", 38.05, 128.42, 100, 30, -5, 90},
    {"ground, Korea, walker", 37.7, 128.5, 2, 120, 0, 90},
    {"ground, Oetztal", 46.85, 10.85, 100, 160, 0, 90},
    {"ground, north pole", 90, 0, 100, 0, -5, 90},
    {"telephoto, Everest", 27.6, 86.6, 3e3, 53, 0, 5},
    {"telephoto, Korea", 37.9, 128.2, 2e3, 70, -4, 5},
    {"telephoto, orbit, Korea", 37, 128, 4e5, 0, -90, 5},
    {"telephoto, orbit, oblique", 33, 128, 4e5, 5, -40, 5},
};

enum { ERROR_VIEW_COUNT = sizeof ERROR_VIEWS / sizeof *ERROR_VIEWS };

#endif
