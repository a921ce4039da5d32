// One batch a viewer: all levels, so that the GPU's program is made a few dozen times only.
#include "transform_sweep.h"

#include <stdlib.h>
#include <string.h>

#include "geo/ring_truth.h"
#include "geo/shared.h"
#include "gpu/shared_kernel.h"
#include "check.h"
#include "report.h"

static const double COLATITUDES[] = {M_PI / 2,  3 * M_PI / 8, M_PI / 4,   M_PI / 8,
                                     M_PI / 16, M_PI / 48,    M_PI / 100, 1e-2,
                                     1e-3,      1e-4,         1e-6,       0};
enum { GIVEN = sizeof COLATITUDES / sizeof *COLATITUDES };

// Heights of the terrain, and where the camera is: over the focus at three heights, and 15 km
// beside it (up, east, north of the focus).
static const float TERRAIN[] = {-418, 0, 1234.5678f, 8848.86f};
static const double CAMERA[][3] = {
    {1.7, 0, 0}, {1235.6789, 0, 0}, {9000.123, 0, 0}, {1235.6789, 9000.3, -12000.7}};
enum { CAMERAS = 4, BESIDE = 3 };

struct vertex {
    struct ring_truth truth;
    int level;
    enum eye eye;
    exact position[3], stored[3]; // from the camera, tangent frame
};

struct sweep {
    ring_params rings;
    int ring_step, column_step, capacity, count;
    struct shared_inputs *in;
    struct shared_outputs *cpu, *gpu;
    struct vertex *vertices;
};

struct viewer {
    struct truth_focus truth;
    struct shared_case base; // the focus's floats
    struct place_frame_f place[CAMERAS];
};

static struct viewer viewer_make(double colatitude, int hemisphere)
{
    geo_ellipsoid e = GEO_WGS84;
    struct viewer v = {.truth = {e, colatitude, hemisphere}};
    double lat = geo_geodetic_from_reduced(e, hemisphere * (M_PI / 2 - colatitude));
    struct geo_focus f;
    for (int i = 0; i < CAMERAS; i++) {
        const double *c = CAMERA[i];
        dvec3 over = geo_ecef_from_geodetic(e, (geodetic){lat, 0, c[0]});
        f = geo_focus_make(e, lat, 0, over, c[0]);
        dvec3 aside = dmat3_mul(dmat3_transpose(f.tangent_from_meridian), (dvec3){0, c[1], c[2]});
        f = geo_focus_make(e, lat, 0, dvec3_add(over, aside), c[0]);
        v.place[i] = geo_place_frame_rounded(&f);
    }
    v.base = (struct shared_case){.cb = (float)f.cb, .sb = (float)f.sb, .r = (float)f.r};
    v.base.lat = (float)lat;
    v.base.stretch = (float)f.stretch;
    v.base.dlat_db = (float)f.dlat_db;
    return v;
}

static void position_of(const struct truth_focus *f, const struct ring_truth *t, double h,
                        const double camera[3], exact out[3])
{
    exact focus[3], from[3], p[3];
    ring_truth_focus(f, focus);
    ring_truth_point(f->ellipsoid, focus, camera[0], from);
    ring_truth_point(f->ellipsoid, t->u, h, p);
    for (int i = 0; i < 3; i++) p[i] -= from[i];
    ring_truth_tangent(f, p, out);
    out[1] -= camera[1];
    out[2] -= camera[2];
}

static void add_vertex(struct sweep *s, const struct viewer *v, int level, int ring, int column)
{
    int i = s->count++;
    struct vertex *x = &s->vertices[i];
    struct shared_case c = v->base;
    float nev[3];
    ring_vertex(&s->rings, ring, column, nev);
    c.n = nev[0], c.e = nev[1], c.v = nev[2];
    double continuous = (double)ring / s->rings.rings_per_level;
    c.w = (float)fmin(fmax((continuous - 9) / 2, 0), 1); // as shaders/lib/map.glsl
    x->level = level;
    int camera = i % CAMERAS;
    x->eye = camera == BESIDE ? BESIDE_FOCUS : OVER_FOCUS;
    c.h = TERRAIN[i / CAMERAS % 4];
    c.place = v->place[camera];
    s->in[i] = shared_inputs_of(&c);
    struct ring_truth stored = ring_truth_stored(&v->truth, nev);
    x->truth = ring_truth_ideal(&v->truth, &s->rings, ring, column);
    position_of(&v->truth, &x->truth, c.h, CAMERA[camera], x->position);
    position_of(&v->truth, &stored, c.h, CAMERA[camera], x->stored);
}

static void add_viewer(struct sweep *s, const struct viewer *v)
{
    int m = s->rings.rings_per_level;
    s->count = 0;
    for (int level = FIRST_LEVEL; level <= LAST_LEVEL; level++)
        for (int j = 0; j <= m; j += s->ring_step)
            for (int c = j % s->column_step; c < ring_columns(&s->rings); c += s->column_step)
                add_vertex(s, v, level, level * m + j, c);
}

static void compute_on_cpu(struct sweep *s)
{
    for (int i = 0; i < s->count; i++) {
        const struct shared_inputs *a = &s->in[i];
        struct shared_outputs *o = &s->cpu[i];
        map_transform_stable_f(a->n, a->e, a->v, a->cb, a->sb, a->r, &o->stable[0], &o->stable[1]);
        map_transform_exact_f(a->n, a->e, a->v, a->cb, a->sb, a->r, a->lat, &o->exact[0],
                              &o->exact[1]);
        map_transform_approx_f(a->n, a->e, a->v, a->stretch, a->dlat_db, &o->approx[0],
                               &o->approx[1]);
        map_transform_blend_f(a->n, a->e, a->v, a->cb, a->sb, a->r, a->lat, a->stretch, a->dlat_db,
                              a->w, &o->blend[0], &o->blend[1]);
        relative_position_f(a->place, a->n, a->e, a->v, a->h, &o->position[0], &o->position[1],
                            &o->position[2]);
    }
}

static void judge_map(const struct viewer *v, const struct vertex *x, const float got[2],
                      struct map_error *e)
{
    double a = v->truth.ellipsoid.a;
    double lat = (double)fabsl(got[1] - x->truth.dlat);
    e->lat_texel = worse(e->lat_texel, lat / (double)ring_truth_lat_texel(x->level));
    e->metres = worse(e->metres, lat * a);
    if (!ring_truth_has_longitude(&x->truth, x->level)) return;
    double lon = (double)fabsl(remainderl(got[0] - x->truth.dlon, 2 * PI_EXACT));
    double rows = (double)(x->truth.rho / ring_truth_lat_texel(x->level));
    double columns = lon / (double)ring_truth_lon_texel(&v->truth, x->level);
    if (rows >= POLE_ROWS) e->lon_texel = worse(e->lon_texel, columns);
    else e->lon_texel_at_pole = worse(e->lon_texel_at_pole, columns);
    e->lon_rows = worse(e->lon_rows, lon * rows);
    e->metres = worse(e->metres, lon * (double)x->truth.rho * a);
}

static void judge_position(const exact want[3], const float got[3], struct position_error *e)
{
    exact error = 0, distance = 0;
    for (int k = 0; k < 3; k++) {
        error = hypotl(error, got[k] - want[k]);
        distance = hypotl(distance, want[k]);
    }
    int bin = distance <= 1e3L   ? 0
              : distance <= 1e4L ? 1
              : distance <= 1e5L ? 2
              : distance <= 1e6L ? 3
                                 : 4;
    e->metres[bin] = worse(e->metres[bin], (double)error);
    e->relative[bin] = worse(e->relative[bin], (double)(error / distance));
}

// The full-screen pass has n and e only; it knows on which side of the quarter turn it is.
static void judge_pixel(const struct viewer *v, const struct vertex *x,
                        const struct shared_inputs *a, struct map_error *e)
{
    float ss = a->n * a->n + a->e * a->e, got[2];
    if (ss > 1) ss = 1;
    float up = ss / (1 + sqrtf(1 - ss));
    map_transform_stable_f(a->n, a->e, up, a->cb, a->sb, a->r, &got[0], &got[1]);
    judge_map(v, x, got, e);
}

static void judge(const struct sweep *s, const struct viewer *v, int k, struct transform_sweep *out)
{
    for (int i = 0; i < s->count; i++) {
        const struct vertex *x = &s->vertices[i];
        for (int d = 0; d < DEVICES; d++) {
            const struct shared_outputs *o = d == CPU ? &s->cpu[i] : &s->gpu[i];
            const float *maps[TRANSFORMS] = {o->stable, o->exact, o->approx, o->blend};
            for (int t = 0; t < TRANSFORMS; t++)
                judge_map(v, x, maps[t], &out->map[t][d][k][x->level]);
            judge_position(x->position, o->position, &out->position[x->eye][d]);
            judge_position(x->stored, o->position, &out->stored[x->eye][d]);
        }
        judge_pixel(v, x, &s->in[i], &out->pixel[x->level]);
    }
    out->vertices += s->count;
}

static int falling(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static void choose_colatitudes(bool dense, struct transform_sweep *out)
{
    struct check_random random = {2006};
    out->colatitudes = GIVEN + (dense ? 20 : 0);
    for (int i = 0; i < out->colatitudes; i++) {
        double even = check_random_range(&random, 0, M_PI / 2);
        double near_pole = M_PI / 2 * pow(10, check_random_range(&random, -9, 0));
        out->colatitude[i] = i < GIVEN ? COLATITUDES[i] : i % 2 ? even : near_pole;
    }
    qsort(out->colatitude, (size_t)out->colatitudes, sizeof(double), falling);
}

static status sweep_init(struct sweep *s, bool dense)
{
    s->rings = (ring_params){dense ? 1024 : 64, 40, LAST_LEVEL + 1};
    s->ring_step = dense ? 1 : 8;
    s->column_step = dense ? 7 : 1;
    int rings = s->rings.rings_per_level / s->ring_step + 1;
    s->capacity = LAST_LEVEL * rings * (ring_columns(&s->rings) / s->column_step + 1);
    size_t n = (size_t)s->capacity;
    s->in = calloc(n, sizeof *s->in);
    s->cpu = calloc(n, sizeof *s->cpu);
    s->gpu = calloc(n, sizeof *s->gpu);
    s->vertices = calloc(n, sizeof *s->vertices);
    return s->in && s->cpu && s->gpu && s->vertices ? OK : ERR_MEMORY;
}

status transform_sweep_run(bool dense, struct transform_sweep *out)
{
    struct sweep s = {0};
    memset(out, 0, sizeof *out);
    choose_colatitudes(dense, out);
    status r = sweep_init(&s, dense);
    for (int i = 0; !r && i < 2 * out->colatitudes; i++) {
        struct viewer v = viewer_make(out->colatitude[i / 2], i % 2 ? -1 : 1);
        add_viewer(&s, &v);
        compute_on_cpu(&s);
        r = shared_kernel_run(s.in, s.gpu, s.count);
        if (!r) judge(&s, &v, i / 2, out);
    }
    free(s.in);
    free(s.cpu);
    free(s.gpu);
    free(s.vertices);
    return r;
}
