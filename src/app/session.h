// What every picture needs: the planet, an OpenGL context without a window, and a view. Main only.
#ifndef PERIGEE_APP_SESSION_H
#define PERIGEE_APP_SESSION_H

#include <stdint.h>

#include "app/image_png.h"
#include "app/options.h"

struct gpu_context;

struct session {
    const struct options *options;
    perigee_planet *planet;
    perigee_planet_info info;
    struct gpu_context *gpu;
    perigee_view *view;
};

// Finds (or makes) and opens the planet that the options name.
status session_open_planet(const struct options *o, struct session *out);

// Prints whose data it is.
void session_credit(const struct session *s);

// Adds the context alone.
status session_open_gpu(struct session *s);

// Adds the context and the view, with the sun where the options have it, and prints the credit and
// the GPU memory taken.
status session_open_view(struct session *s);

void session_close(struct session *s);

// A camera's latitude and longitude as a place of the planet's map, and the camera the other way
// round (perigee_planet_map_place).
status session_place(const struct session *s, perigee_camera *camera);
perigee_camera session_geographic(const struct session *s, const perigee_camera *camera);

// A camera's place on the map of a projected raster, in the units of its reference system; else
// false, and NaN.
bool session_map_coordinates(const struct session *s, const perigee_camera *camera, double *easting,
                             double *northing);

// Places of the map, in place, as they are told: geographic. *coordinates: of a projected raster
// count eastings and then as many northings, owned; else NULL. ERR_MEMORY, logged.
status session_tell_places(const struct session *s, size_t count, double *lat_deg, double *lon_deg,
                           double **coordinates);

// The camera of the options: what is not given has its default, heights above ground become
// altitudes, its place is the map's. ERR_ARGUMENT, logged, when it is below the terrain; one
// off a projected map is warned of.
status session_camera(const struct session *s, perigee_camera *out);

// Streams until a frame of this size is complete (unless --no-wait). ERR_TIMEOUT, with the list of
// what is missing logged.
status session_wait(const struct session *s, int width, int height);

// The texts that go into a picture's file, with room for the camera's line. Returns their number.
enum { SESSION_TEXTS = 3, SESSION_CAMERA_SIZE = 160 };
int session_texts(const struct session *s, const perigee_camera *camera,
                  char line[SESSION_CAMERA_SIZE], struct image_text texts[SESSION_TEXTS]);

#endif
