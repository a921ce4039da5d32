// The form of Losasso & Hoppe 2004: of each level's render region four rectangles, cropped to the
// frustum, their indices written by the CPU each frame, and zero-area triangles along the border.
// One level's indices are on the GPU at a time.
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/context.h"
#include "render/planar_parts.h"

enum { SLABS = 16, RECTANGLES = 4 };

struct instance {
    uint32_t row, column, level, number;
};

struct planar_rectangles {
    int n, columns; // vertices; columns + 1 of level 0 close the circle
    GLuint vertex_array, vertices, instances, index_buffer;
    uint32_t *indices;
    size_t capacity; // indices
    int count[CLIPMAP_MAX_LEVELS];
    planar_region rectangle[CLIPMAP_MAX_LEVELS][RECTANGLES];
};

static void make_vertices(struct planar *p, struct planar_rectangles *o)
{
    size_t count = (size_t)o->n * (size_t)o->columns;
    uint16_t *v = NEW_ARRAY(uint16_t, 2 * count);
    for (size_t i = 0; i < count; i++) {
        v[2 * i] = (uint16_t)(i / (size_t)o->columns);
        v[2 * i + 1] = (uint16_t)(i % (size_t)o->columns);
    }
    glCreateBuffers(1, &o->vertices);
    glNamedBufferStorage(o->vertices, (GLsizeiptr)(4 * count), v, 0);
    p->gpu_bytes += 4 * count;
    free(v);
}

// The quads of level l, then its border.
static void make_instances(struct planar *p, struct planar_rectangles *o)
{
    struct instance all[2 * CLIPMAP_MAX_LEVELS];
    for (uint32_t i = 0; i < 2 * CLIPMAP_MAX_LEVELS; i++)
        all[i] = (struct instance){.level = i / 2 | (i % 2 ? PLANAR_IS_BORDER : 0), .number = i};
    glCreateBuffers(1, &o->instances);
    glNamedBufferStorage(o->instances, sizeof all, all, 0);
    p->gpu_bytes += sizeof all;
}

status planar_rectangles_create(struct planar *p, struct planar_rectangles **out)
{
    struct planar_rectangles *o = NEW(struct planar_rectangles);
    gpu_context_forgive();
    o->n = p->n;
    o->columns = p->n + 2;
    o->capacity = 6 * (size_t)(o->n + 1) * (size_t)(o->n + 1);
    o->indices = NEW_ARRAY(uint32_t, o->capacity);
    make_vertices(p, o);
    make_instances(p, o);
    glCreateBuffers(1, &o->index_buffer);
    glNamedBufferData(o->index_buffer, (GLsizeiptr)(o->capacity * sizeof *o->indices), NULL,
                      GL_STREAM_DRAW);
    p->gpu_bytes += o->capacity * sizeof *o->indices;
    o->vertex_array = planar_vertex_array(o->vertices, o->instances, o->index_buffer);
    *out = o;
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused the vertices of squares of %d", p->n);
    return ERR_GPU;
}

void planar_rectangles_destroy(struct planar_rectangles **rectangles)
{
    struct planar_rectangles *o = *rectangles;
    if (!o) return;
    const GLuint buffers[] = {o->vertices, o->instances, o->index_buffer};
    glDeleteBuffers(3, buffers);
    glDeleteVertexArrays(1, &o->vertex_array);
    free(o->indices);
    free(o);
    *rectangles = NULL;
}

// Takes slabs off one side while nothing of them can be seen. side: 0, 1 the first and last rows,
// 2, 3 the columns.
static void crop_side(const struct planar *p, const geometry_frame *f, int level, int side,
                      planar_region *r)
{
    int step = p->n / SLABS + 1;
    while (!planar_region_empty(*r)) {
        planar_region slab = *r;
        int *ends[4] = {&slab.row1, &slab.row0, &slab.column1, &slab.column0};
        int *edge[4] = {&r->row0, &r->row1, &r->column0, &r->column1};
        int to = *edge[side] + (side % 2 ? -step : step);
        int last = side == 0 ? r->row1 : side == 1 ? r->row0 : side == 2 ? r->column1 : r->column0;
        if (side % 2 ? to < last : to > last) to = last;
        *ends[side] = to;
        if (planar_visible(p, f, level, slab)) return;
        *edge[side] = to;
    }
}

uint64_t planar_rectangles_select(struct planar_rectangles *o, const struct planar *p,
                                  const geometry_frame *f)
{
    uint64_t triangles = 0;
    for (int level = p->first; level <= p->last; level++) {
        planar_region finer = {0}, parts[RECTANGLES];
        if (level < p->last)
            finer = planar_region_in_coarser(&p->square[level + 1], &p->square[level],
                                             p->active[level + 1]);
        int count = planar_region_frame(p->active[level], finer, parts);
        o->count[level] = 0;
        for (int i = 0; i < count; i++) {
            for (int side = 0; side < 4; side++) crop_side(p, f, level, side, &parts[i]);
            if (planar_region_empty(parts[i])) continue;
            o->rectangle[level][o->count[level]++] = parts[i];
            triangles += 2 * (uint64_t)(parts[i].row1 - parts[i].row0) *
                         (uint64_t)(parts[i].column1 - parts[i].column0);
        }
    }
    return triangles;
}

// Two triangles a quad as in planar_pieces.h.
static uint32_t *write_quads(const struct planar_rectangles *o, planar_region r, uint32_t *next)
{
    for (int row = r.row0; row < r.row1; row++) {
        for (int column = r.column0; column < r.column1; column++) {
            uint32_t nw = (uint32_t)(row * o->columns + column), sw = nw + (uint32_t)o->columns;
            const uint32_t six[6] = {sw + 1, nw + 1, nw, sw, sw + 1, nw};
            for (int i = 0; i < 6; i++) *next++ = six[i];
        }
    }
    return next;
}

static uint32_t *write_border_side(uint32_t first, int steps, int step, uint32_t *next)
{
    for (int i = 0; i < steps; i += 2, first += 2 * (uint32_t)step) {
        *next++ = first;
        *next++ = first + 2 * (uint32_t)step;
        *next++ = first + (uint32_t)step;
    }
    return next;
}

static uint32_t *write_border(const struct planar_rectangles *o, planar_region r, uint32_t *next)
{
    int rows = r.row1 - r.row0, columns = r.column1 - r.column0;
    uint32_t nw = (uint32_t)(r.row0 * o->columns + r.column0),
             ne = (uint32_t)(r.row0 * o->columns + r.column1),
             sw = (uint32_t)(r.row1 * o->columns + r.column0);
    next = write_border_side(nw, columns, 1, next);
    next = write_border_side(sw, columns, 1, next);
    next = write_border_side(nw, rows, o->columns, next);
    return write_border_side(ne, rows, o->columns, next);
}

static void draw_range(size_t first, size_t count, int instance)
{
    if (count)
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, (GLsizei)count, GL_UNSIGNED_INT,
                                            (const void *)(uintptr_t)(first * sizeof(uint32_t)), 1,
                                            (GLuint)instance);
}

// Fine to coarse, so that what is hidden is not shaded.
void planar_rectangles_draw(struct planar_rectangles *o, const struct planar *p,
                            geometry_counts *counts)
{
    glBindVertexArray(o->vertex_array);
    for (int level = p->last; level >= p->first; level--) {
        uint32_t *next = o->indices;
        for (int i = 0; i < o->count[level]; i++)
            next = write_quads(o, o->rectangle[level][i], next);
        size_t quads = (size_t)(next - o->indices);
        if (level > p->first) next = write_border(o, p->active[level], next);
        size_t all = (size_t)(next - o->indices);
        glNamedBufferData(o->index_buffer, (GLsizeiptr)(all * sizeof *o->indices), o->indices,
                          GL_STREAM_DRAW);
        draw_range(0, quads, 2 * level);
        glDisable(GL_CULL_FACE); // as in planar_footprints.c
        draw_range(quads, all - quads, 2 * level + 1);
        glEnable(GL_CULL_FACE);
        counts->triangles_drawn += all / 3;
        counts->draws += (quads > 0) + (all > quads);
    }
}
