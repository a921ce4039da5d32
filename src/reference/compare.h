// What one picture of the planet has wrong against another: depth and colour of picture A judged by
// picture B (the reference) of the same camera, pixel by pixel. Pixel (x, y) is the ray through its
// centre, top row first; depths are metres along the view axis, NaN is sky.
//
// Where both show ground and no silhouette is near, with P the points of the ray at A's and at B's
// depth, N the unit normal of B's surface and J the derivative of the projection to the screen at
// P_b:
//
//     d = (P_a - P_b) . N         metres by which A's point lies above B's tangent plane
//     geometric error = |d J N|   pixels by which the surface would be seen to move
//     distance        = |d| / pixel's size at P_b along the view axis
//
// An edge lies between two pixels, side by side or one above the other, of which one shows sky, or
// whose tangent planes leave a step of more than EDGE_STEP_PX pixel sizes that neither a convex nor
// a concave surface through both would have. The silhouette is every pixel with an edge in its 3 x
// 3 neighbourhood in either picture, and those between an edge of B and the same edge of A. There
// the displacement of edges is measured instead (compare_edges.h).
#ifndef PERIGEE_REFERENCE_COMPARE_H
#define PERIGEE_REFERENCE_COMPARE_H

#include "reference/reference.h"

// NULL planes are not known. Colour: linear light, compared where all three of both are there.
// Normals (ECEF, unit, upward): without them they come from the depths of neighbours.
typedef struct compare_picture {
    const float *z_m;
    const double *lat_deg, *lon_deg;
    const float *r, *g, *b;
    const float *nx, *ny, *nz;
} compare_picture;

typedef struct compare_params {
    geo_ellipsoid ellipsoid;
    reference_camera camera;
    int width, height; // px, 1 to 16384
    compare_picture a, b;
} compare_params;

enum compare_kind {
    COMPARE_SKY,        // in both
    COMPARE_GROUND,     // in both
    COMPARE_SILHOUETTE, // ground in both, near an edge
    COMPARE_MISSING,    // ground in B, sky in A
    COMPARE_EXTRA,      // sky in B, ground in A
};

// Of |values|. rank r: the least value that at least the share r does not exceed. NaN, and x = y =
// -1, when count is 0.
typedef struct compare_stat {
    size_t count;
    double mean, rms, median, rank_999, max;
    int x, y;                // of the maximum
    double lat_deg, lon_deg; // there, NaN when not known
} compare_stat;

typedef struct compare_result {
    size_t pixels, sky, ground, silhouette, missing, extra; // one of each kind for each pixel
    // Holes: missing pixels that are not the place of a silhouette. Those have sky of B in their 3
    // x 3 neighbourhood, or nothing but missing pixels between them and B's sky within
    // EDGE_SEARCH_PX along their row or column, and are no slit in A's ground; limb_px tells how
    // far the silhouette is off.
    size_t missing_inside;
    size_t extra_outside; // with no ground of B in the 3 x 3 neighbourhood
    compare_stat geometric_px, distance_px, depth_m, depth_relative; // COMPARE_GROUND
    compare_stat
        geometric_all_px;    // with the silhouette, where it says more about edges than ground
    compare_stat limb_px;    // displacement of edges against the sky of B
    compare_stat ridge_px;   // of those against ground of B
    size_t edges_a, edges_b; // as many edges are in each picture
    size_t edges_only_a, edges_only_b; // without the same edge of the other within EDGE_SEARCH_PX
    size_t colors;                     // pixels whose colour was compared: ground in both
    double mse, psnr_db; // 10 log10(1 / mse), mse of R, G, B sRGB-encoded in [0, 1]; NaN: no colour
} compare_result;

// width * height each, NULL: not wanted; NaN where not measured.
typedef struct compare_maps {
    float *geometric_px;  // signed: positive where A lies above B's surface; ground and silhouette
    float *depth_m;       // z of A less z of B; ground and silhouette
    float *silhouette_px; // at the near pixel of each edge of B; EDGE_SEARCH_PX + 1: not found
    unsigned char *kind;  // enum compare_kind
} compare_maps;

// ERR_MEMORY, logged. Any thread.
status compare_pictures(const compare_params *params, const compare_maps *maps,
                        compare_result *out);

// Linear light, clamped to [0, 1], as sRGB encodes it, in [0, 1] (IEC 61966-2-1).
double compare_encoded(double light);

// A short English word for the kind.
const char *compare_kind_name(enum compare_kind kind);

#endif
