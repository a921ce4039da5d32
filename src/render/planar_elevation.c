// Invariant: a level's map holds what the shader would compute now, for its key says from what it
// was computed: square, windows, whether there is a coarser level. Nothing in it depends on the
// camera, so levels computed in different frames agree to the last bit.
#include "render/planar_elevation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "gpu/context.h"
#include "gpu/program.h"
#include "render/fleeting.h"

enum { WINDOWS = 24, MARGIN = 5 }; // samples at a window's border that are weighed less

struct key {
    int64_t row, column;
    uint64_t heights;
    int sampled; // window level; -1: nothing computed yet
    bool coarser;
};

struct planar_elevation {
    int n, kept;
    GLuint texture, program;
    GLenum format;
    size_t bytes;
    struct key keys[CLIPMAP_MAX_LEVELS];
};

status planar_elevation_create(const planar_elevation_params *p, struct planar_elevation **out)
{
    struct planar_elevation *e = NEW(struct planar_elevation);
    *e = (struct planar_elevation){.n = p->n, .kept = p->kept};
    for (int i = 0; i < CLIPMAP_MAX_LEVELS; i++) e->keys[i].sampled = -1;
    gpu_context_forgive();
    int layers = p->kept < p->levels ? p->kept + FLEETING_LAYERS : p->levels;
    e->format = p->packed ? GL_R32F : GL_RG32F;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &e->texture);
    glTextureStorage3D(e->texture, 1, e->format, p->n + 1, p->n + 1, layers);
    glTextureParameteri(e->texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(e->texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    e->bytes = (size_t)(p->n + 1) * (size_t)(p->n + 1) * (size_t)layers * (p->packed ? 4 : 8);
    status s = OK;
    if (glGetError() != GL_NO_ERROR) {
        log_error("the GPU refused %zu MiB of elevation maps", e->bytes >> 20);
        s = ERR_GPU;
    }
    if (!s) s = gpu_program_create_compute("planar/elevation.comp", p->defines, &e->program);
    if (s) planar_elevation_destroy(&e);
    *out = e;
    return s;
}

void planar_elevation_destroy(struct planar_elevation **elevation)
{
    struct planar_elevation *e = *elevation;
    if (!e) return;
    glDeleteTextures(1, &e->texture);
    if (e->program) glDeleteProgram(e->program);
    free(e);
    *elevation = NULL;
}

GLuint planar_elevation_texture(const struct planar_elevation *e)
{
    return e->texture;
}

size_t planar_elevation_bytes(const struct planar_elevation *e)
{
    return e->bytes;
}

int planar_height_level(const nest_square *s)
{
    int level = nest_globe_level(s->plane, s->level);
    return level > 0 ? level : 0;
}

static int sampled_level(const struct windows *w, const nest_square *s)
{
    int own = planar_height_level(s) + (int)fmin(windows_lead(w), 0), last = windows_last_height(w);
    return own < 0 ? 0 : own > last ? last : own;
}

int planar_elevation_kept(const struct windows *w, int levels, bool plane)
{
    int kept = windows_kept(w) - (int)fmin(windows_lead(w), 0) + (plane ? NEST_PLANE_LEVELS : 0);
    return windows_fleeting(w) && kept < levels ? kept : levels;
}

// Where the square's vertices lie in a window: the row of the first and the rows from one to the
// next, the same of columns. All are small multiples of powers of two, so exact in floats.
static void place_square(const nest_square *s, const window *held, const window_shape *shape,
                         float out[4])
{
    double circle = (double)s->circle, held_circle = ldexp(shape->cols, held->share);
    double rows = ldexp(256, held->zoom) / (circle / 2), columns = held_circle / circle;
    double first = (double)s->column * columns - (double)held->rect.col0;
    double off = first + s->n / 2 * columns - shape->cols / 2.0;
    out[0] = (float)((double)s->row * rows - (double)held->rect.row0);
    out[1] = (float)rows;
    out[2] = (float)(first - held_circle * floor(off / held_circle + 0.5));
    out[3] = (float)columns;
}

static int clamp_index(double i, int n)
{
    return (int)clamp_double(i, -1, n + 2);
}

// Rows beyond a pole are at it.
planar_region planar_elevation_clip(const struct windows *w, const struct levels_block *block,
                                    const nest_square *s)
{
    int level = sampled_level(w, s);
    window held = windows_held(w, level);
    window_shape shape = windows_height_samples(w);
    float place[4];
    place_square(s, &held, &shape, place);
    const float *valid = block->height_valid[level];
    double first[2] = {place[0], place[2]}, step[2] = {place[1], place[3]};
    int ends[4];
    for (int i = 0; i < 4; i++) {
        int k = i / 2, sign = i % 2 ? -1 : 1;
        double at = (valid[i] + sign * MARGIN - first[k]) / step[k];
        ends[i] = clamp_index(sign > 0 ? ceil(at) : floor(at), s->n);
    }
    if (ends[0] <= -s->row) ends[0] = -1;
    if (ends[1] >= s->circle / 2 - s->row) ends[1] = s->n + 2;
    return (planar_region){ends[0], ends[1], ends[2], ends[3]};
}

static void compute(const struct windows *w, const nest_square *s, const nest_square *coarser,
                    int sampled)
{
    float places[WINDOWS][4] = {{0}};
    window_shape shape = windows_height_samples(w);
    for (int i = 0; i <= sampled; i++) {
        window held = windows_held(w, i);
        place_square(s, &held, &shape, places[i]);
    }
    int64_t far = 1 << 20, north = -s->row, south = s->circle / 2 - s->row;
    if (s->plane) north = -far, south = far;
    glUniform4i(0, s->level, sampled, (GLint)(north < -far ? -far : north),
                (GLint)(south > far ? far : south));
    glUniform4i(1, coarser ? (GLint)(s->row / 2 - coarser->row) : 0,
                coarser ? (GLint)(s->column / 2 - coarser->column) : 0, s->n, coarser != NULL);
    glUniform4fv(2, WINDOWS, places[0]);
    glDispatchCompute((GLuint)(s->n + 1 + 15) / 16, (GLuint)(s->n + 3) / 4, 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

uint64_t planar_elevation_update(struct planar_elevation *e, struct windows *w,
                                 const nest_square *squares, int coarsest, int first, int last)
{
    uint64_t vertices = 0;
    if (first >= e->kept) windows_make(w, sampled_level(w, &squares[first]), false);
    glUseProgram(e->program);
    glBindImageTexture(0, e->texture, 0, GL_TRUE, 0, GL_READ_WRITE, e->format);
    for (int i = first; i <= last; i++) {
        const nest_square *s = &squares[i];
        struct key key = {.row = s->row,
                          .column = s->column,
                          .heights = windows_heights_version(w, planar_height_level(s)),
                          .sampled = sampled_level(w, s),
                          .coarser = i > coarsest};
        const struct key *held = &e->keys[i];
        if (i < e->kept && held->row == key.row && held->column == key.column &&
            held->heights == key.heights && held->sampled == key.sampled &&
            held->coarser == key.coarser)
            continue;
        compute(w, s, i > coarsest ? &squares[i - 1] : NULL, key.sampled);
        e->keys[i] = key;
        vertices += (uint64_t)e->n * (uint64_t)e->n;
    }
    if (vertices) glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return vertices;
}
