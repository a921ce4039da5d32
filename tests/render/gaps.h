// Looking for gaps in a frame: background where the planet must be, and ground seen through a crack
// in nearer ground. Judged by the camera model and the analytic terrain of scene.h; the identifier
// buffer tells what met at a place.
#ifndef PERIGEE_TESTS_RENDER_GAPS_H
#define PERIGEE_TESTS_RENDER_GAPS_H

#include "render/scene.h"

enum { GAPS_WIDTH = 200, GAPS_HEIGHT = 150, GAPS_PIXELS = GAPS_WIDTH * GAPS_HEIGHT };

// What can meet.
enum gaps_border {
    GAPS_LEVEL,        // two levels
    GAPS_FILL,         // the finest ring and the disc inside it
    GAPS_SECTOR,       // two sectors that share their vertices
    GAPS_SEAM,         // the two copies of a meridian line
    GAPS_POLE,         // the meridians
    GAPS_ANTIMERIDIAN, // the map's two ends
    GAPS_BORDERS
};
extern const char *const gaps_border_names[GAPS_BORDERS];

// A frame read back.
struct gaps_frame {
    float z[GAPS_PIXELS];
    double lat[GAPS_PIXELS], lon[GAPS_PIXELS]; // deg
    uint32_t triangle[GAPS_PIXELS];
    int level[GAPS_PIXELS], sector[GAPS_PIXELS];
    int last_level;
    bool late; // data was still under way
};

struct gaps_counts {
    int inside;       // pixels whose ray meets the ellipsoid lowered beneath the deepest terrain,
                      // and by what the limb may lie too low; flat: whose ray passes from the
                      // highest terrain to the lowest over the map
    int background;   // of those, how many show no planet
    int cracks;       // pixels that show what lies behind ground that their neighbours show
    int beyond;       // flat: pixels that show ground off the map
    int unidentified; // pixels with depth but no triangle, or the other way round
};

// Reads the last frame of a view made with `identify`, rendered at the size above.
void gaps_read(perigee_view *view, struct gaps_frame *frame);

// limb_px: by how many pixels the limb may lie too low; flat: the map's edge too far in.
struct gaps_counts gaps_find(const perigee_camera *camera, const struct gaps_frame *frame,
                             double limb_px);

// How many pairs of neighbouring pixels in the middle third of the picture have one pixel on each
// side of a border of the kind, both drawn by a triangle. GAPS_POLE: how many of the four quarters
// of longitude are seen there, 0 unless all are.
int gaps_met(const struct gaps_frame *frame, enum gaps_border border);

#endif
