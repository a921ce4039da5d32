// Perigee in somebody else's OpenGL context: ./embed earth.planet
#include <perigee.h>

#include <stdio.h>

#include "host.h"

int main(int argc, char **argv)
{
    perigee_planet *planet = NULL;
    perigee_view *view = NULL;
    perigee_camera camera = {.lat_deg = 45.6, .lon_deg = 10.7, .alt_m = 2e7, .pitch_deg = -90};

    if (argc != 2 || host_start(640, 480)) return 2;
    perigee_status failed = perigee_planet_open(argv[1], NULL, &planet);
    if (!failed) failed = perigee_view_create(planet, NULL, &view);
    if (!failed) failed = perigee_view_set_camera(view, &camera);
    if (!failed) failed = perigee_view_wait(view, 640, 480, 60.0);
    if (!failed) failed = perigee_view_render(view, 640, 480);
    if (failed) fprintf(stderr, "embed: %s\n", perigee_last_error());
    else printf("%d of %d pixels are not black\n", host_lit_pixels(), 640 * 480);
    perigee_view_destroy(&view);
    perigee_planet_close(&planet);
    host_stop();
    return failed ? 1 : 0;
}
