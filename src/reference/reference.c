#include "reference/reference.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "reference/body.h"
#include "reference/light.h"
#include "reference/normal.h"

#define RAD (M_PI / 180)

enum { BLOCK_PX = 32, MAX_SIZE_PX = 16384 };

// Of the work, how much finding the ground is taken for.
#define SIGHT_SHARE      0.3
#define DEFAULT_ERROR_PX 0.05

// East, north, up and from them right, up, forward of the camera.
struct aim {
    dvec3 origin, right, up, forward;
};

static struct aim aim_of(geo_ellipsoid e, const reference_camera *c)
{
    body_frame f = body_frame_at(e, c->lat_deg, c->lon_deg, c->alt_m);
    dvec3 east = f.east, north = f.north, up = f.up;
    double sh = sin(c->heading_deg * RAD), ch = cos(c->heading_deg * RAD),
           sp = sin(c->pitch_deg * RAD), cp = cos(c->pitch_deg * RAD), sr = sin(c->roll_deg * RAD),
           cr = cos(c->roll_deg * RAD);
    dvec3 ahead = dvec3_mad(dvec3_scale(north, ch), east, sh);
    dvec3 forward = dvec3_mad(dvec3_scale(ahead, cp), up, sp);
    dvec3 right = dvec3_mad(dvec3_scale(east, ch), north, -sh);
    dvec3 top = dvec3_cross(right, forward);
    return (struct aim){.origin = body_point(e, c->lat_deg, c->lon_deg, c->alt_m),
                        .right = dvec3_mad(dvec3_scale(right, cr), top, -sr),
                        .up = dvec3_mad(dvec3_scale(top, cr), right, sr),
                        .forward = forward};
}

static dvec3 direction(const struct aim *a, const reference_camera *c, int width, int height,
                       double x_px, double y_px)
{
    double scale = 2 * tan(c->fov_deg * RAD / 2) / height;
    dvec3 d = dvec3_mad(a->forward, a->right, (x_px - 0.5 * width) * scale);
    return dvec3_mad(d, a->up, (0.5 * height - y_px) * scale);
}

void reference_ray(geo_ellipsoid e, const reference_camera *camera, int width, int height,
                   double x_px, double y_px, dvec3 *origin, dvec3 *dir)
{
    struct aim aim = aim_of(e, camera);
    *origin = aim.origin;
    *dir = direction(&aim, camera, width, height, x_px, y_px);
}

struct picture {
    const reference_params *params;
    const reference_planes *planes;
    struct sight *sight;
    struct field_reader *readers; // one for each worker
    struct aim aim;
    dvec3 sun;
    double pixel;
    _Atomic status error;
};

struct block {
    struct picture *picture;
    int x, y;
};

static void put(float *plane, size_t at, double value)
{
    if (plane) plane[at] = (float)value;
}

static void put_pixel(const reference_planes *p, size_t at, const ray_hit *hit, double z,
                      const double rgb[3], double level)
{
    put(p->r, at, rgb[0]);
    put(p->g, at, rgb[1]);
    put(p->b, at, rgb[2]);
    put(p->z_m, at, z);
    put(p->height_m, at, hit->height);
    put(p->level, at, level);
    if (p->lat_deg) p->lat_deg[at] = hit->lat;
    if (p->lon_deg) p->lon_deg[at] = hit->lon;
}

static void put_normal(const reference_planes *p, size_t at, dvec3 normal)
{
    put(p->nx, at, normal.x);
    put(p->ny, at, normal.y);
    put(p->nz, at, normal.z);
}

static void render_pixel(struct picture *p, struct field_reader *reader, int x, int y)
{
    const reference_params *q = p->params;
    size_t at = (size_t)y * (size_t)q->width + (size_t)x;
    dvec3 d = direction(&p->aim, &q->camera, q->width, q->height, x + 0.5, y + 0.5);
    double length = dvec3_length(d), rgb[3] = {0, 0, 0};
    d = dvec3_scale(d, 1 / length);
    ray_hit hit;
    if (!sight_cast(p->sight, reader, d, &hit)) {
        hit = (ray_hit){NAN, NAN, NAN, NAN};
        put_pixel(p->planes, at, &hit, NAN, rgb, -1);
        put_normal(p->planes, at, dvec3_make(NAN, NAN, NAN));
        return;
    }
    if (p->planes->r || p->planes->g || p->planes->b)
        light_at(reader, &hit, d, p->sun, p->pixel, rgb);
    if (p->planes->nx || p->planes->ny || p->planes->nz)
        put_normal(p->planes, at, normal_at_hit(reader, &hit));
    put_pixel(p->planes, at, &hit, hit.t / length, rgb, field_zoom(reader->field));
}

static void render_block(void *arg, int worker)
{
    struct block *b = arg;
    struct picture *p = b->picture;
    struct field_reader *reader = &p->readers[worker];
    int right = b->x + BLOCK_PX < p->params->width ? b->x + BLOCK_PX : p->params->width;
    int bottom = b->y + BLOCK_PX < p->params->height ? b->y + BLOCK_PX : p->params->height;
    for (int y = b->y; y < bottom; y++)
        for (int x = b->x; x < right && !p->error; x++) {
            render_pixel(p, reader, x, y);
            if (reader->error) p->error = reader->error;
        }
}

static status render_blocks(struct picture *p, struct pool *pool)
{
    const reference_params *q = p->params;
    int across = (q->width + BLOCK_PX - 1) / BLOCK_PX, down = (q->height + BLOCK_PX - 1) / BLOCK_PX;
    int count = across * down;
    struct block *blocks = NEW_ARRAY(struct block, (size_t)count);
    bool cancelled = false;
    for (int i = 0; i < count && !p->error && !cancelled; i++) {
        blocks[i] = (struct block){p, i % across * BLOCK_PX, i / across * BLOCK_PX};
        pool_submit(pool, render_block, &blocks[i]);
        double done = SIGHT_SHARE + (1 - SIGHT_SHARE) * i / count;
        cancelled = q->progress.report && q->progress.report(q->progress.user, done);
    }
    pool_drain(pool);
    free(blocks);
    return p->error ? p->error : cancelled ? ERR_CANCELLED : OK;
}

static status refuse(const char *what, double value)
{
    log_error("reference: impossible %s %g", what, value);
    return ERR_ARGUMENT;
}

static status check(const reference_params *p)
{
    const reference_camera *c = &p->camera;
    double low = -pyramid_meta(p->pyramid)->ellipsoid.b / 2;
    if (p->width < 1 || p->width > MAX_SIZE_PX) return refuse("width", p->width);
    if (p->height < 1 || p->height > MAX_SIZE_PX) return refuse("height", p->height);
    if (p->zoom < SIGHT_AUTO || p->zoom > GRID_MAX_ZOOM) return refuse("zoom", p->zoom);
    if (!(p->error_px >= 0 && p->error_px <= 1e3)) return refuse("error", p->error_px);
    if (!(fabs(c->lat_deg) <= 90)) return refuse("latitude", c->lat_deg);
    if (!isfinite(c->lon_deg)) return refuse("longitude", c->lon_deg);
    if (!(c->alt_m >= low && c->alt_m <= 1e12)) return refuse("altitude", c->alt_m);
    if (!isfinite(c->heading_deg)) return refuse("heading", c->heading_deg);
    if (!isfinite(c->pitch_deg)) return refuse("pitch", c->pitch_deg);
    if (!isfinite(c->roll_deg)) return refuse("roll", c->roll_deg);
    if (!(c->fov_deg >= 0.01 && c->fov_deg <= 179)) return refuse("field of view", c->fov_deg);
    if (p->threads < 0 || p->threads > 256) return refuse("number of threads", p->threads);
    if (p->has_sun && !(fabs(dvec3_length(p->sun) - 1) < 1e-6))
        return refuse("length of the sun's direction", dvec3_length(p->sun));
    return OK;
}

static status render(struct picture *p, struct pool *pool)
{
    int threads = pool_threads(pool);
    p->readers = NEW_ARRAY(struct field_reader, (size_t)threads);
    for (int i = 0; i < threads; i++)
        field_reader_init(&p->readers[i], sight_nearest(p->sight), p->params->pyramid);
    status s = render_blocks(p, pool);
    for (int i = 0; i < threads; i++) field_reader_deinit(&p->readers[i]);
    free(p->readers);
    return s;
}

static bool report_sight(void *user, double done)
{
    const reference_progress *p = user;
    return p->report && p->report(p->user, SIGHT_SHARE * done);
}

// The planes through the eye and the edges of the picture.
static field_sight view_of(const struct aim *a, const reference_params *p)
{
    double up = tan(p->camera.fov_deg * RAD / 2), across = up * p->width / p->height;
    const dvec3 edge[2] = {a->right, a->up};
    const double slope[2] = {across, up};
    field_sight s = {.eye = a->origin, .sides = FIELD_MAX_SIDES};
    for (int i = 0; i < FIELD_MAX_SIDES; i++)
        s.side[i] = dvec3_normalize(
            dvec3_mad(dvec3_scale(a->forward, slope[i / 2]), edge[i / 2], i % 2 ? 1 : -1));
    return s;
}

static status find_ground(struct picture *p, struct pool *pool)
{
    const reference_params *q = p->params;
    const reference_progress part = {report_sight, (void *)&q->progress};
    sight_params params = {.pyramid = q->pyramid,
                           .view = view_of(&p->aim, q),
                           .pixel = p->pixel,
                           .zoom = q->zoom,
                           .bicubic = q->bicubic,
                           .error_px = q->error_px > 0 ? q->error_px : DEFAULT_ERROR_PX};
    status s = sight_create(&params, pool, &part, &p->sight);
    if (!s && q->ground) *q->ground = sight_get_ground(p->sight);
    return s;
}

status reference_render(const reference_params *params, const reference_planes *planes)
{
    status s = check(params);
    if (s) return s;
    const struct planet_meta *m = pyramid_meta(params->pyramid);
    struct picture p = {.params = params, .planes = planes};
    p.aim = aim_of(m->ellipsoid, &params->camera);
    p.sun = params->has_sun ? params->sun : body_noon(m->ellipsoid, p.aim.origin);
    p.pixel = 2 * tan(params->camera.fov_deg * RAD / 2) / params->height;
    struct pool *pool = pool_create(params->threads, 4);
    s = find_ground(&p, pool);
    if (!s) s = render(&p, pool);
    sight_destroy(&p.sight);
    pool_destroy(&pool);
    return s;
}
