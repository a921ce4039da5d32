#include "render/normals.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/vec.h"
#include "gpu/program.h"
#include "render/texture_array.h"

enum { REACH_MAX = 8, MAX_PENDING = 64 }; // columns, of normals.comp; rectangles

struct pending {
    window_rect rects[MAX_PENDING];
    int count, zoom, share;
};

struct normals {
    geo_ellipsoid ellipsoid;
    window_shape shape;
    GLuint texture, convexity, program;
    size_t bytes;
    struct pending pending[CLIPMAP_MAX_LEVELS];
};

status normals_create(const normals_params *p, struct normals **out)
{
    struct normals *n = NEW(struct normals);
    *n = (struct normals){.ellipsoid = p->ellipsoid, .shape = p->shape};
    n->texture = texture_array(GL_RG16_SNORM, &p->shape, p->layers, GL_NEAREST);
    n->convexity = texture_array(GL_R8_SNORM, &p->shape, p->convexity_layers, GL_LINEAR);
    n->bytes = texture_array_bytes(&p->shape, p->layers, 4) +
               texture_array_bytes(&p->shape, p->convexity_layers, 1);
    status s = gpu_program_create_compute("normals/normals.comp", p->defines, &n->program);
    if (s) normals_destroy(&n);
    *out = n;
    return s;
}

void normals_destroy(struct normals **normals)
{
    struct normals *n = *normals;
    if (!n) return;
    glDeleteTextures(1, &n->texture);
    glDeleteTextures(1, &n->convexity);
    if (n->program) glDeleteProgram(n->program);
    free(n);
    *normals = NULL;
}

GLuint normals_texture(const struct normals *n)
{
    return n->texture;
}

GLuint normals_convexity(const struct normals *n)
{
    return n->convexity;
}

size_t normals_gpu_bytes(const struct normals *n)
{
    return n->bytes;
}

static void begin(const struct normals *n, GLuint heights)
{
    glUseProgram(n->program);
    glBindTextureUnit(0, heights);
    glBindImageTexture(0, n->texture, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG16_SNORM);
    glBindImageTexture(1, n->convexity, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8_SNORM);
}

static void end(void)
{
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

// `rect` and the samples around it that see it: a row's length away along great circles, and what
// heights are the mean of there.
static window_rect seen_from(const struct normals *n, const window *held, window_rect rect)
{
    const int64_t last = (int64_t)(M_PI / window_step_lat(held) + 0.5);
    int64_t from_pole = rect.row0 < last - rect.row1 ? rect.row0 : last - rect.row1;
    from_pole = from_pole > 3 ? from_pole - 3 : 0;
    double step_lon = window_step_lon(&n->shape, held);
    double columns =
        window_step_lat(held) / sin(((double)from_pole + 0.5) * window_step_lat(held)) / step_lon;
    double reach = fmin(columns, REACH_MAX), wide = 1 + 1.3 * clamp_double(columns - 1, 0, 1);
    int64_t cols = (int64_t)ceil(reach + wide), rows = from_pole < 26 ? 2 : 1;
    return (window_rect){rect.row0 - rows, rect.row1 + rows, rect.col0 - cols, rect.col1 + cols};
}

// Normals of `rect` and of the samples around it that see it, as far as they are `valid` in the
// window that the level's texture holds.
static void compute(const struct normals *n, const window *held, window_rect valid,
                    window_rect rect)
{
    rect = window_rect_intersect(seen_from(n, held, rect), valid);
    if (window_rect_empty(rect)) return;
    const window_shape *shape = &n->shape;
    int64_t row0 = held->rect.row0, col0 = held->rect.col0;
    int rows = (int)(rect.row1 - rect.row0), cols = (int)(rect.col1 - rect.col0);
    int tex_row = window_texel(row0, shape->rows), tex_col = window_texel(col0, shape->cols);
    double step_lat = window_step_lat(held), step_lon = window_step_lon(shape, held);
    glUniform4i(0, (int)(rect.row0 - row0), rows, (int)(rect.col0 - col0), cols);
    glUniform4i(1, tex_row, tex_col, held->level, held->share == 0);
    glUniform4i(2, (int)(valid.row0 - row0), (int)(valid.row1 - row0), (int)(valid.col0 - col0),
                (int)(valid.col1 - col0));
    int64_t circle = (int64_t)shape->cols << held->share;
    glUniform1i(3, (int)row0);
    glUniform2ui(5, (GLuint)((col0 % circle + circle) % circle), (GLuint)circle);
    glUniform2f(6, (float)step_lat, (float)step_lon);
    glUniform2f(4, (float)n->ellipsoid.a, (float)n->ellipsoid.b);
    glDispatchCompute((GLuint)(cols + 15) / 16, (GLuint)(rows + 3) / 4, 1);
}

void normals_make(const struct normals *n, GLuint heights, const window *w, window_rect rect)
{
    begin(n, heights);
    compute(n, w, rect, rect);
    end();
}

void normals_note(struct normals *n, const clipmap_strip *strip)
{
    struct pending *p = &n->pending[strip->level];
    if (p->zoom != strip->window.zoom || p->share != strip->window.share) p->count = 0;
    p->zoom = strip->window.zoom;
    p->share = strip->window.share;
    if (p->count < MAX_PENDING) p->rects[p->count++] = strip->rect;
    else p->rects[0] = strip->window.rect; // too many to tell apart: the whole window
}

void normals_update(struct normals *n, GLuint heights, const struct clipmap *clipmap)
{
    begin(n, heights);
    for (int i = 0; i < CLIPMAP_MAX_LEVELS; i++) {
        struct pending *p = &n->pending[i];
        if (!p->count) continue;
        clipmap_level l = clipmap_level_state(clipmap, i);
        if (l.held.zoom != p->zoom || l.held.share != p->share) continue;
        if (!window_rect_equal(l.valid, l.held.rect)) continue;
        for (int k = 0; k < p->count; k++) compute(n, &l.held, l.valid, p->rects[k]);
        p->count = 0;
    }
    end();
}
