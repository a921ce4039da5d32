// A bundle of rays marched over coarse heights, each step a share of the height above them: it
// chooses the place of the rings and so only their cost and error, never where the ground is.
#include "render/gaze.h"

#include <math.h>

#include "base/vec.h"

enum { RAYS_ACROSS = 3, RAYS_DOWN = 5, MAX_STEPS = 120 };

enum haste { WAITS, TRIES, GUESSES };

struct probe {
    struct pyramid *pyramid;
    const struct planet_meta *meta;
    enum haste haste;
    struct want *want; // of one who tries
    bool exact;        // no tile was missing so far
    dvec3 eye;
};

static int finest_zoom(const struct planet_meta *m)
{
    return m->max_zoom[LAYER_HEIGHT] < 0 ? 0 : m->max_zoom[LAYER_HEIGHT];
}

// The ground, in the data at *zoom or, where that is not at hand, at the zoom left there.
static double ground_at(struct probe *b, int *zoom, double lat, double lon)
{
    double ground = 0;
    status s = OK;
    if (b->haste == WAITS) s = pyramid_height_at(b->pyramid, *zoom, lat, lon, &ground);
    if (b->haste == TRIES) s = pyramid_height_try(b->pyramid, *zoom, lat, lon, b->want, &ground);
    if (b->haste != GUESSES && !s) return ground;
    int held = pyramid_height_held(b->pyramid, *zoom, lat, lon, &ground);
    b->exact &= held == *zoom;
    *zoom = held > 0 ? held : 0;
    return ground;
}

// Metres from the camera down to the terrain as samples of a zoom have it, less what finer detail
// may add where there is none finer: a fiftieth of their spacing.
static double clear_of(struct probe *b, const geodetic *p, int *zoom, double *spacing)
{
    double ground = ground_at(b, zoom, p->lat, p->lon);
    *spacing = grid_step_lat(*zoom) * b->meta->ellipsoid.a;
    return p->height - ground - 0.02 * *spacing;
}

// Metres from the camera down to the terrain. By the data under the camera and, nearer than half
// the spacing of their samples, by finer and finer ones: what synthesis makes of a slope was seen
// to leave it by a twentieth of the spacing, 184 m in the Alps. Continuous in the camera's place.
static double clearance(struct probe *b, const geodetic *p)
{
    const double far = 0.5, near = 0.25, finest = 0.2; // in spacings; m
    const struct planet_meta *m = b->meta;
    double top = 2 * m->height_max + 1e5, below = clamp_double(2 - 2 * p->height / top, 0, 1);
    if (below <= 0) return p->height;
    double clear = 0, rest = 1, spacing = INFINITY;
    for (int zoom = finest_zoom(m), held = zoom; rest > 0; held = ++zoom) {
        double c = clear_of(b, p, &held, &spacing), finer = (far - c / spacing) / (far - near);
        finer = held < zoom || spacing <= finest ? 0 : clamp_double(finer, 0, 1);
        clear += rest * (1 - finer) * c;
        rest *= finer;
    }
    return below * clear + (1 - below) * p->height;
}

// Height above samples about a sixty-fourth of the distance wide; NaN off a plane's map.
static double gap_at(struct probe *b, dvec3 dir, double t)
{
    geo_ellipsoid e = b->meta->ellipsoid;
    geodetic g = geo_geodetic_from_ecef(e, dvec3_mad(b->eye, dir, t));
    bool on_map = g.lat >= e.south && g.lat <= e.north && g.lon >= e.west && g.lon <= e.east;
    if (geo_is_plane(e) && !on_map) return NAN;
    double rows = M_PI * b->meta->ellipsoid.a / (t / 64);
    int zoom = (int)clamp_double(floor(log2(rows / 256)), 0, finest_zoom(b->meta));
    return g.height - ground_at(b, &zoom, g.lat, g.lon);
}

// Distance along a ray (unit, ECEF) to the ground, NaN when it meets none.
static double distance_along(struct probe *b, dvec3 dir, double start)
{
    geo_ellipsoid e = b->meta->ellipsoid;
    double top = b->meta->height_max + 1, t = start;
    if (geo_geodetic_from_ecef(e, b->eye).height > top) t = geo_ray_ellipsoid(e, top, b->eye, dir);
    for (int i = 0; i < MAX_STEPS && t < 3 * e.a + 10 * start; i++) {
        double gap = gap_at(b, dir, t);
        if (isnan(gap)) return NAN;
        if (gap < 2e-3 * t) return t;
        t += fmax(0.7 * gap, 0.02 * t);
    }
    return NAN;
}

// Harmonic mean of the distances of what the picture shows; NaN: only sky. A sample at the distance
// d is about as wide as it is far from the focus, and shows 1 / d: |D - d| / d is the same at the
// nearest and the farthest d, and below the nadir's 1, for D their harmonic mean.
static double distance_seen(struct probe *b, const geo_camera *c, double aspect, double start,
                            double *nearest)
{
    dmat3 eye = geo_eye_over(b->meta->ellipsoid, c);
    double t = tan(c->fov_y / 2), sum = 0;
    int hits = 0;
    *nearest = INFINITY;
    for (int i = 0; i < RAYS_ACROSS * RAYS_DOWN; i++) {
        double x = (2 * (i % RAYS_ACROSS + 0.5) / RAYS_ACROSS - 1) * t * aspect,
               y = (2 * ((int)(i / RAYS_ACROSS) + 0.5) / RAYS_DOWN - 1) * t;
        dvec3 dir = dvec3_scale(eye.row[2], -1);
        dir = dvec3_mad(dvec3_mad(dir, eye.row[0], x), eye.row[1], y);
        double d = distance_along(b, dvec3_normalize(dir), start);
        if (isnan(d)) continue;
        sum += 1 / d;
        hits++;
        *nearest = fmin(*nearest, d);
    }
    return hits ? hits / sum : NAN;
}

// 1 up to GAZE_NARROW, 0 from GAZE_WIDE on.
static double narrowness(double fov_y)
{
    double x = clamp_double((GAZE_WIDE - fov_y) / (GAZE_WIDE - GAZE_NARROW), 0, 1);
    return x * x * (3 - 2 * x);
}

static gaze look(struct probe *b, const geo_camera *camera, double aspect)
{
    b->meta = pyramid_meta(b->pyramid);
    b->exact = true;
    geo_ellipsoid e = b->meta->ellipsoid;
    const geodetic *p = &camera->position;
    double down = clearance(b, p), share = narrowness(camera->fov_y), nearest;
    gaze nadir = {p->lat, p->lon, down, down, false, b->exact};
    if (share <= 0) return nadir;
    b->eye = geo_ecef_from_geodetic(e, *p);
    double distance = distance_seen(b, camera, aspect, fmax(down, 1), &nearest);
    nadir.exact = b->exact;
    if (isnan(distance)) return nadir;
    dvec3 forward = dvec3_scale(geo_eye_over(e, camera).row[2], -1);
    geodetic g = geo_geodetic_from_ecef(e, dvec3_mad(b->eye, forward, share * distance));
    if (geo_is_plane(e)) {
        g.lat = clamp_double(g.lat, e.south, e.north);
        g.lon = clamp_double(g.lon, e.west, e.east);
    }
    return (gaze){g.lat, g.lon, down + share * fmax(distance - down, 0), nearest, true, b->exact};
}

gaze gaze_find(struct pyramid *pyramid, const geo_camera *camera, double aspect)
{
    return look(&(struct probe){.pyramid = pyramid}, camera, aspect);
}

gaze gaze_try(struct pyramid *pyramid, const geo_camera *camera, double aspect, struct want *want)
{
    return look(&(struct probe){.pyramid = pyramid, .haste = TRIES, .want = want}, camera, aspect);
}

gaze gaze_guess(struct pyramid *pyramid, const geo_camera *camera, double aspect)
{
    return look(&(struct probe){.pyramid = pyramid, .haste = GUESSES}, camera, aspect);
}
