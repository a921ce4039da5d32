// Vertex buffers: ring coordinates (n~, e~, v~), written once (the fill's rows by each placing),
// and positions relative to the camera, written only for cells that became visible or stale.
// Neighbouring cells share the vertices of their border and compute them from the same numbers, so
// there is nothing to crack.
#include "render/spherical.h"

#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/program.h"

struct spherical {
    ring_params rings;
    bool any_level; // as in the parameters
    GLuint ring_buffer, place_buffer, index_buffer, cell_buffer, vertex_array;
    GLuint place_program, mesh_program;
    int cells;
    uint64_t *placed; // per cell: the epoch at which it was placed
    uint64_t epoch;
    int fill_of;    // `last` for which the fill is placed
    uint32_t *work; // 4 a cell
    // multi-draw arguments
    GLsizei *counts;
    const void **offsets;
    GLint *bases;
    int *drawn;                         // the cell of each draw
    GLsizei ring_indices, fill_indices; // of one cell
    size_t gpu_bytes;
};

static int vertex_rows(const ring_params *r)
{
    return ring_count(r) + CELL_FILL_RINGS + 1;
}

// Two triangles a quad, counter-clockwise seen from above: azimuth grows clockwise from north,
// rings inwards. The last vertex of both is that of the outer ring and smaller azimuth, by which
// mesh.frag tells a quad from all others.
static uint32_t *write_quads(uint32_t *out, int rings, int steps, uint32_t columns)
{
    for (uint32_t j = 0; j < (uint32_t)rings; j++) {
        for (uint32_t i = 0; i < (uint32_t)steps; i++) {
            uint32_t outer = j * columns + i, inner = outer + columns;
            *out++ = inner + 1;
            *out++ = outer + 1;
            *out++ = outer;
            *out++ = inner;
            *out++ = inner + 1;
            *out++ = outer;
        }
    }
    return out;
}

static void make_indices(struct spherical *s)
{
    int steps = s->rings.azimuth_steps / CELL_SECTORS, half = s->rings.rings_per_level / CELL_BANDS;
    uint32_t columns = (uint32_t)ring_columns(&s->rings);
    s->ring_indices = half * steps * 6;
    s->fill_indices = CELL_FILL_RINGS * steps * 6;
    size_t count = (size_t)(s->ring_indices + s->fill_indices);
    uint32_t *indices = NEW_ARRAY(uint32_t, count);
    uint32_t *next = write_quads(indices, half, steps, columns);
    write_quads(next, CELL_FILL_RINGS, steps, columns);
    glNamedBufferStorage(s->index_buffer, (GLsizeiptr)(count * sizeof *indices), indices, 0);
    s->gpu_bytes += count * sizeof *indices;
    free(indices);
}

static void make_rings(struct spherical *s)
{
    int columns = ring_columns(&s->rings), rings = ring_count(&s->rings),
        rows = vertex_rows(&s->rings);
    size_t bytes = (size_t)rows * (size_t)columns * 3 * sizeof(float);
    float *v = NEW_ARRAY(float, (size_t)rows *(size_t)columns * 3);
    for (int r = 0; r < rings; r++)
        for (int c = 0; c < columns; c++)
            ring_vertex(&s->rings, r, c, v + 3 * ((size_t)r * (size_t)columns + (size_t)c));
    glNamedBufferStorage(s->ring_buffer, (GLsizeiptr)bytes, v, 0);
    glNamedBufferStorage(s->place_buffer, (GLsizeiptr)bytes, NULL, 0);
    s->gpu_bytes += 2 * bytes;
    free(v);
}

static void make_vertex_array(struct spherical *s)
{
    glCreateVertexArrays(1, &s->vertex_array);
    const GLuint buffers[2] = {s->place_buffer, s->ring_buffer};
    for (GLuint i = 0; i < 2; i++) {
        glVertexArrayVertexBuffer(s->vertex_array, i, buffers[i], 0, 3 * sizeof(float));
        glVertexArrayAttribFormat(s->vertex_array, i, 3, GL_FLOAT, GL_FALSE, 0);
        glVertexArrayAttribBinding(s->vertex_array, i, i);
        glEnableVertexArrayAttrib(s->vertex_array, i);
    }
    glVertexArrayElementBuffer(s->vertex_array, s->index_buffer);
}

static status make_buffers(struct spherical *s)
{
    while (glGetError() != GL_NO_ERROR) {
    }
    glCreateBuffers(1, &s->ring_buffer);
    glCreateBuffers(1, &s->place_buffer);
    glCreateBuffers(1, &s->index_buffer);
    glCreateBuffers(1, &s->cell_buffer);
    make_indices(s);
    make_rings(s);
    size_t work = (size_t)s->cells * 4 * sizeof(uint32_t);
    glNamedBufferStorage(s->cell_buffer, (GLsizeiptr)work, NULL, GL_DYNAMIC_STORAGE_BIT);
    s->gpu_bytes += work;
    make_vertex_array(s);
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu MiB of ring geometry", s->gpu_bytes >> 20);
    return ERR_GPU;
}

status spherical_create(const spherical_params *params, struct spherical **out)
{
    struct spherical *s = NEW(struct spherical);
    s->rings = params->rings;
    s->any_level = params->any_level;
    s->cells = cell_count(&s->rings);
    size_t cells = (size_t)s->cells;
    s->placed = NEW_ARRAY(uint64_t, cells);
    s->epoch = 1;
    s->work = NEW_ARRAY(uint32_t, cells * 4);
    s->counts = NEW_ARRAY(GLsizei, cells);
    s->offsets = NEW_ARRAY(const void *, cells);
    s->bases = NEW_ARRAY(GLint, cells);
    s->drawn = NEW_ARRAY(int, cells);
    status r = make_buffers(s);
    if (!r) r = gpu_program_create_compute("place/place.comp", params->defines, &s->place_program);
    if (!r)
        r = gpu_program_create_render("mesh/mesh.vert", "mesh/mesh.frag", params->defines,
                                      &s->mesh_program);
    if (r) spherical_destroy(&s);
    *out = s;
    return r;
}

void spherical_destroy(struct spherical **spherical)
{
    struct spherical *s = *spherical;
    if (!s) return;
    const GLuint buffers[] = {s->ring_buffer, s->place_buffer, s->index_buffer, s->cell_buffer};
    glDeleteBuffers(4, buffers);
    glDeleteVertexArrays(1, &s->vertex_array);
    if (s->place_program) glDeleteProgram(s->place_program);
    if (s->mesh_program) glDeleteProgram(s->mesh_program);
    free(s->placed);
    free(s->work);
    free(s->counts);
    free(s->offsets);
    free(s->bases);
    free(s->drawn);
    free(s);
    *spherical = NULL;
}

size_t spherical_gpu_bytes(const struct spherical *s)
{
    return s->gpu_bytes;
}

void spherical_invalidate(struct spherical *s)
{
    s->epoch++;
}

// Work items of one kind lie together, because a dispatch covers cells of one size.
static uint32_t place_cells(struct spherical *s, uint32_t first, uint32_t count, uint64_t *placed)
{
    if (!count) return 0;
    uint32_t vertices = s->work[4 * first + 1] * s->work[4 * first + 3];
    glUniform1ui(0, first);
    glDispatchCompute((vertices + 63) / 64, count, 1);
    *placed += (uint64_t)vertices * count;
    return count;
}

static void place(struct spherical *s, uint32_t ring_cells, uint32_t fill_cells, uint64_t *placed)
{
    if (!(ring_cells + fill_cells)) return;
    glNamedBufferSubData(s->cell_buffer, 0,
                         (GLsizeiptr)((ring_cells + fill_cells) * 4 * sizeof *s->work), s->work);
    glUseProgram(s->place_program);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s->cell_buffer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, s->ring_buffer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, s->place_buffer);
    glUniform1ui(1, (GLuint)ring_count(&s->rings));
    glUniform1ui(2, CELL_FILL_RINGS);
    place_cells(s, 0, ring_cells, placed);
    place_cells(s, ring_cells, fill_cells, placed);
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
}

struct selection {
    GLsizei draws;
    uint32_t work;
    uint64_t triangles;
};

static void select_cell(struct spherical *s, int cell, bool fill, struct selection *sel)
{
    cell_span v = cell_vertices(&s->rings, cell);
    GLsizei indices = fill ? s->fill_indices : s->ring_indices;
    s->counts[sel->draws] = indices;
    uintptr_t offset = fill ? (size_t)s->ring_indices * sizeof(uint32_t) : 0;
    s->offsets[sel->draws] = (const void *)offset;
    s->bases[sel->draws] = (GLint)(v.row * (uint32_t)ring_columns(&s->rings) + v.column);
    s->drawn[sel->draws] = cell;
    sel->draws++;
    sel->triangles += (uint64_t)indices / 3;
    if (s->placed[cell] == s->epoch) return;
    s->placed[cell] = s->epoch;
    uint32_t *w = s->work + 4 * sel->work++;
    w[0] = v.row;
    w[1] = v.rows;
    w[2] = v.column;
    w[3] = v.columns;
}

static void band_heights(const struct spherical *s, const struct windows *w, int level, double *low,
                         double *high)
{
    windows_height_bounds(w, level, low, high);
    for (int i = level - 1; s->any_level && i >= 0; i--) {
        double lower, higher;
        windows_height_bounds(w, i, &lower, &higher);
        *low = lower < *low ? lower : *low;
        *high = higher > *high ? higher : *high;
    }
}

static void select_band(struct spherical *s, const struct windows *w, const cell_view *view,
                        int level, int band, int last, bool cull, struct selection *sel)
{
    double low, high;
    band_heights(s, w, level < last ? level : last, &low, &high);
    bool fill = level == s->rings.levels;
    for (int k = 0; k < CELL_SECTORS; k++) {
        int cell = cell_index(level, band, k);
        if (!cull || cell_visible(&s->rings, view, cell, last, low, high))
            select_cell(s, cell, fill, sel);
    }
}

void spherical_draw(struct spherical *s, const struct windows *w, const cell_view *view, int first,
                    int last, bool cull, struct spherical_counts *counts)
{
    if (s->fill_of != last) {
        for (int k = 0; k < CELL_SECTORS; k++) s->placed[cell_fill_index(&s->rings, k)] = 0;
        spherical_invalidate(s); // the innermost ring's own level changes with it
        s->fill_of = last;
    }
    struct selection sel = {0};
    for (int level = last; level >= first; level--) // near to far
        for (int band = CELL_BANDS - 1; band >= 0; band--)
            select_band(s, w, view, level, band, last, cull, &sel);
    uint32_t ring_work = sel.work;
    select_band(s, w, view, s->rings.levels, 0, last, cull, &sel);
    place(s, ring_work, sel.work - ring_work, &counts->vertices_placed);

    uint64_t per_level = (uint64_t)s->rings.azimuth_steps * (uint64_t)s->rings.rings_per_level * 2;
    counts->triangles_total =
        per_level * (uint64_t)(last - first + 1) + (uint64_t)s->fill_indices / 3 * CELL_SECTORS;
    counts->triangles_drawn = sel.triangles;
    counts->draws = sel.draws > 0;
    glUseProgram(s->mesh_program);
    glBindVertexArray(s->vertex_array);
    if (sel.draws)
        glMultiDrawElementsBaseVertex(GL_TRIANGLES, s->counts, GL_UNSIGNED_INT,
                                      (const void *const *)s->offsets, sel.draws, s->bases);
}

int spherical_drawn_cell(const struct spherical *s, uint32_t draw)
{
    return s->drawn[draw];
}
