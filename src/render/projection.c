#include "render/projection.h"

#include <math.h>
#include <string.h>

#include "geo/horizon.h"

// Rayleigh scale height of the simple atmosphere, m.
#define AIR_SCALE_HEIGHT_M 8000.0

static dmat3 mat_mul(dmat3 a, dmat3 b)
{
    dmat3 t = dmat3_transpose(b), r;
    for (int i = 0; i < 3; i++) r.row[i] = dmat3_mul(t, a.row[i]);
    return r;
}

projection projection_make(geo_ellipsoid e, const geo_camera *camera, double focus_lat,
                           double focus_lon, int width, int height)
{
    projection p = {.ellipsoid = e, .camera = *camera, .width = width, .height = height};
    p.camera_ecef = geo_ecef_from_geodetic(e, camera->position);
    p.focus = geo_focus_make(e, focus_lat, focus_lon, p.camera_ecef, camera->position.height);
    p.eye_from_meridian =
        mat_mul(geo_eye_over(e, camera), dmat3_transpose(p.focus.meridian_from_ecef));
    return p;
}

static void set4(float out[4], double x, double y, double z, double w)
{
    out[0] = (float)x;
    out[1] = (float)y;
    out[2] = (float)z;
    out[3] = (float)w;
}

static double aspect(const projection *p)
{
    return (double)p->width / p->height;
}

static void fill_matrix(const projection *p, float out[16])
{
    double f = 1 / tan(p->camera.fov_y / 2);
    dmat3 eye = mat_mul(p->eye_from_meridian, dmat3_transpose(p->focus.tangent_from_meridian));
    dvec3 right = eye.row[0], up = eye.row[1], back = eye.row[2];
    double jx = 2 * p->jitter_x / p->width, jy = -2 * p->jitter_y / p->height;
    dvec3 x = dvec3_mad(dvec3_scale(right, f / aspect(p)), back, -jx);
    dvec3 y = dvec3_mad(dvec3_scale(up, f), back, -jy);
    const double rows[4][4] = {{x.x, x.y, x.z, 0},
                               {y.x, y.y, y.z, 0},
                               {0, 0, 0, PROJECTION_NEAR_M},
                               {-back.x, -back.y, -back.z, 0}};
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 4; r++) out[4 * c + r] = (float)rows[r][c];
}

static void fill_place(const struct geo_focus *focus, struct view_block *b)
{
    struct place_frame_f f = geo_place_frame_rounded(focus);
    set4(b->place_scale, f.east, f.east_low, f.north, f.north_low);
    set4(b->place_shape, f.drop, f.grade, f.q, f.skew);
    set4(b->place_up, f.href, f.href_low, f.up_offset, f.up_offset_low);
    set4(b->place_along, f.east_offset, f.east_offset_low, f.north_offset, f.north_offset_low);
}

// The view ray at NDC (x, y), 1 along the view axis, meridian frame.
static dvec3 ray(const projection *p, double x, double y)
{
    double t = tan(p->camera.fov_y / 2);
    x -= 2 * p->jitter_x / p->width;
    y += 2 * p->jitter_y / p->height;
    dvec3 d = dvec3_scale(p->eye_from_meridian.row[2], -1);
    d = dvec3_mad(d, p->eye_from_meridian.row[0], x * t * aspect(p));
    return dvec3_mad(d, p->eye_from_meridian.row[1], y * t);
}

// The camera in the scaled space where the ellipsoid is the unit sphere, meridian frame; over a
// plane as if a sphere touched it below the camera.
static dvec3 scaled_camera(const projection *p)
{
    if (geo_is_plane(p->ellipsoid))
        return dvec3_make(1 + p->camera.position.height / p->ellipsoid.a, 0, 0);
    dvec3 c = dmat3_mul(p->focus.meridian_from_ecef, p->camera_ecef);
    return dvec3_make(c.x / p->ellipsoid.a, c.y / p->ellipsoid.a, c.z / p->ellipsoid.b);
}

void projection_fill_block(const projection *p, dvec3 sun_ecef, bool sky_glow, struct view_block *b)
{
    const struct geo_focus *f = &p->focus;
    fill_matrix(p, b->clip_from_tangent);
    dvec3 centre = ray(p, 0, 0), right = dvec3_sub(ray(p, 1, 0), centre),
          up = dvec3_sub(ray(p, 0, 1), centre);
    set4(b->ray_centre, centre.x, centre.y, centre.z, 0);
    set4(b->ray_right, right.x, right.y, right.z, 0);
    set4(b->ray_up, up.x, up.y, up.z, 0);
    set4(b->focus, f->cb, f->sb, f->r, f->lat);
    set4(b->focus_paper, f->reduced, f->stretch, f->dlat_db, 0);
    set4(b->axes, p->ellipsoid.a, p->ellipsoid.b, 0, 0);
    fill_place(f, b);
    dvec3 camera = scaled_camera(p);
    set4(b->camera, camera.x, camera.y, camera.z, dvec3_length(camera) - 1);
    dvec3 sun = dmat3_mul(f->meridian_from_ecef, sun_ecef);
    bool plane = geo_is_plane(p->ellipsoid);
    set4(b->sun, sun.x, sun.y, sun.z, plane ? 1 : cos(f->lon));
    double h = AIR_SCALE_HEIGHT_M / p->ellipsoid.a;
    set4(b->atmosphere, 1 / h, 1 / h, sky_glow ? 1 : 0, plane ? 0 : sin(f->lon));
    geo_ellipsoid e = p->ellipsoid;
    set4(b->map_edge, e.south - f->lat, e.north - f->lat, e.west - f->lon, e.east - f->lon);
    set4(b->screen, p->width, p->height, PROJECTION_NEAR_M,
         geo_pixel_size(1, p->camera.fov_y, p->height));
}

cell_view projection_cell_view(const projection *p, double lowest, double summit)
{
    cell_view v = {.ellipsoid = p->ellipsoid,
                   .lat = p->focus.lat,
                   .lon = p->focus.lon,
                   .cb = p->focus.cb,
                   .sb = p->focus.sb};
    v.camera = dmat3_mul(p->focus.meridian_from_ecef, p->camera_ecef);
    double grow = 1 + 2.0 / fmin(p->width, p->height); // a pixel of room for the jitter
    dvec3 tl = ray(p, -grow, grow), tr = ray(p, grow, grow), bl = ray(p, -grow, -grow),
          br = ray(p, grow, -grow);
    v.plane[0] = dvec3_normalize(dvec3_cross(bl, tl));
    v.plane[1] = dvec3_normalize(dvec3_cross(tr, br));
    v.plane[2] = dvec3_normalize(dvec3_cross(br, bl));
    v.plane[3] = dvec3_normalize(dvec3_cross(tl, tr));
    v.plane[4] = dvec3_scale(p->eye_from_meridian.row[2], -1);
    dvec3 nadir = dvec3_normalize(scaled_camera(p)), centre = dvec3_make(v.cb, 0, v.sb);
    v.nadir_angle = 2 * asin(fmin(1, dvec3_length(dvec3_sub(nadir, centre)) / 2));
    v.horizon = geo_horizon_angle(p->ellipsoid, p->camera_ecef, fmin(lowest, 0), summit);
    cell_view_azimuths(&v);
    const geodetic *at = &p->camera.position;
    if (geo_is_plane(p->ellipsoid)) v.nadir_angle = hypot(at->lat - v.lat, at->lon - v.lon);
    return v;
}

dvec3 projection_unproject(const projection *p, double x_px, double y_px, double z)
{
    return dvec3_scale(ray(p, 2 * x_px / p->width - 1, 1 - 2 * y_px / p->height), z);
}

double projection_pixel(const projection *p)
{
    return geo_pixel_size(1, fmin(p->camera.fov_y, PROJECTION_WIDE_FOV), p->height);
}

double projection_reach(const cell_view *view)
{
    double reach = view->horizon + view->nadir_angle;
    return geo_is_plane(view->ellipsoid) ? ring_plane_angle(reach) : fmin(reach, M_PI);
}

int projection_first_level(const cell_view *view)
{
    double level = ring_level_of_angle(projection_reach(view));
    return level < 0 ? 0 : (int)floor(level);
}

// Where samples are as wide as a pixel, between levels.
static double last_level(const projection *p, double distance, double rows)
{
    double pixel = fmax(distance, 0.1) * projection_pixel(p) / p->ellipsoid.a;
    return log2(2 * M_PI / (rows * pixel));
}

int projection_last_level(const projection *p, double distance, double rows, int levels)
{
    return (int)clamp_double(ceil(last_level(p, distance, rows)), 2, levels - 1);
}

double projection_last_level_age(const projection *p, double distance, double rows, int levels)
{
    double level = last_level(p, distance, rows), age = level - ceil(level) + 1;
    return level <= 2 || level > levels - 1 ? INFINITY : age;
}
