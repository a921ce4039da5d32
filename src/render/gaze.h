// What the camera looks at: where the rings' focus stands and how far its ground is. A wide view
// has it at the nadir. A narrow one has it towards the ground in its middle, where the whole
// picture is small beside its distance: the finest rings are needed there, not under the camera.
#ifndef PERIGEE_RENDER_GAZE_H
#define PERIGEE_RENDER_GAZE_H

#include "geo/camera.h"
#include "planet/pyramid.h"

typedef struct gaze {
    double lat, lon; // of the focus: geodetic, rad
    double distance; // from the camera to the ground there, m; under the nadir: no more than that
    double nearest;  // from the camera to the nearest ground seen, m
    bool aside;      // the focus is not the nadir
    bool exact;      // found with all the tiles that it depends on
} gaze;

// Vertical fields of view, rad, up to which the focus is where the camera looks, and from which on
// it is the nadir; between them it slides along the great circle.
#define GAZE_NARROW (20 * M_PI / 180)
#define GAZE_WIDE   (45 * M_PI / 180)

// A function of its arguments and of the planet's data alone, when `exact`; without tiles that it
// depends on, coarser ones in memory do. aspect: width / height of the picture. Any thread.

// Waits for the disk, and for the network.
gaze gaze_find(struct pyramid *pyramid, const geo_camera *camera, double aspect);
// Reads the disk, but does not wait for the network: the want has a share in what is on its way.
gaze gaze_try(struct pyramid *pyramid, const geo_camera *camera, double aspect, struct want *want);
// From what is in memory.
gaze gaze_guess(struct pyramid *pyramid, const geo_camera *camera, double aspect);

#endif
