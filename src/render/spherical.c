// The spherical clipmap's support geometry: static rings, cells, placing by compute, one
// multi-draw.
//
// Buffers: the rings' rows and columns, of which ring coordinates (n~, e~, v~) are made, written
// once (the fill's rows with each finest level), and vertices' positions relative to the camera,
// written only for cells that became visible or stale. Neighbouring cells share the vertices of
// their border and compute them from the same numbers, so there is nothing to crack.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/log.h"
#include "base/memory.h"
#include "geo/horizon.h"
#include "gpu/context.h"
#include "gpu/program.h"
#include "render/geometry.h"
#include "render/params.h"
#include "render/stride.h"

struct index_list {
    size_t offset; // bytes
    GLsizei count;
};

struct strides {
    int rings, columns;
};

struct spherical {
    struct geometry base;
    ring_params rings;
    double spacing_px;
    bool cull;
    // The transform may be off by more than a level's window (the paper's are, near the ground), so
    // that a height can come from any coarser level.
    bool any_level;
    bool sharp; // heights
    bool plane; // the body
    GLuint row_buffer, column_buffer, place_buffer, index_buffer, cell_buffer, vertex_array;
    GLuint place_program, mesh_program;
    int cells;
    uint64_t *placed;              // per cell: the epoch at which it was placed
    struct strides *strides;       // per cell: of the vertices then placed
    uint64_t epoch, before_placed; // at which the rings of the fill before were placed
    int fill_of;                   // `last` for which the fill is placed
    float *thinned; // per band: stride of its rings, share by which every second of them has slid
    uint32_t *work; // 4 a cell
    // multi-draw arguments
    GLsizei *counts;
    const void **offsets;
    GLint *bases;
    int *drawn;             // the cell of each draw
    uint32_t *draw_strides; // and its strides, which identifiers need
    GLuint stride_buffer;   // 0: no identifiers
    struct index_list lists[STRIDE_COUNT]
                           [STRIDE_COUNT + 1]; // by columns' and rings' stride; the fill
    size_t gpu_bytes;
};

// After the rings the fill's, then those of the outer half of the fill that was there before the
// finest level came in, between that level's first ring and the fill that is there now.
enum { FILL_ROWS = CELL_FILL_RINGS + 1, BEFORE_ROWS = CELL_FILL_RINGS / 2 - 1 };

static int vertex_rows(const ring_params *r)
{
    return ring_count(r) + FILL_ROWS + BEFORE_ROWS;
}

// Two triangles a quad, counter-clockwise seen from above: azimuth grows clockwise from north,
// rings inwards. The last vertex of both is that of the outer ring and smaller azimuth, by which
// mesh.frag tells a quad from all others.
static uint32_t *write_quads(uint32_t *out, int rings, int steps, struct strides by,
                             uint32_t columns)
{
    uint32_t down = (uint32_t)by.rings * columns, right = (uint32_t)by.columns;
    for (uint32_t j = 0; j < (uint32_t)rings; j += (uint32_t)by.rings) {
        for (uint32_t i = 0; i < (uint32_t)steps; i += right) {
            uint32_t outer = j * columns + i, inner = outer + down;
            *out++ = inner + right;
            *out++ = outer + right;
            *out++ = outer;
            *out++ = inner;
            *out++ = inner + right;
            *out++ = outer;
        }
    }
    return out;
}

// The index lists of a cell: for each pair of strides that divide it, rings' bands and the fill.
static void make_indices(struct spherical *s)
{
    int steps = s->rings.azimuth_steps / CELL_SECTORS, half = s->rings.rings_per_level / CELL_BANDS;
    uint32_t columns = (uint32_t)ring_columns(&s->rings);
    size_t most = (size_t)(4 * half + 2 * CELL_FILL_RINGS) * (size_t)steps * 6;
    uint32_t *indices = NEW_ARRAY(uint32_t, most), *next = indices;
    for (int c = 0; c < STRIDE_COUNT; c++) {
        for (int r = 0; r <= STRIDE_COUNT; r++) {
            bool fill = r == STRIDE_COUNT;
            int rings = fill ? CELL_FILL_RINGS : half;
            struct strides by = {fill ? 1 : 1 << r, 1 << c};
            uint32_t *start = next;
            if (rings % by.rings == 0 && steps % by.columns == 0)
                next = write_quads(next, rings, steps, by, columns);
            s->lists[c][r] = (struct index_list){(size_t)(start - indices) * sizeof *indices,
                                                 (GLsizei)(next - start)};
        }
    }
    size_t bytes = (size_t)(next - indices) * sizeof *indices;
    glNamedBufferStorage(s->index_buffer, (GLsizeiptr)bytes, indices, 0);
    s->gpu_bytes += bytes;
    free(indices);
}

static ring_row row_at(const struct spherical *s, double angle)
{
    return s->plane ? ring_plane_row_at(angle) : ring_row_at(angle);
}

static void make_rings(struct spherical *s)
{
    int columns = ring_columns(&s->rings), rings = ring_count(&s->rings),
        rows = vertex_rows(&s->rings);
    ring_row *row = NEW_ARRAY(ring_row, (size_t)rows);
    ring_column *column = NEW_ARRAY(ring_column, (size_t)columns);
    for (int r = 0; r < rings; r++) row[r] = row_at(s, ring_angle(&s->rings, r));
    for (int c = 0; c < columns; c++) column[c] = ring_column_at(&s->rings, c);
    size_t row_bytes = (size_t)rows * sizeof *row, column_bytes = (size_t)columns * sizeof *column,
           place_bytes = (size_t)rows * (size_t)columns * 3 * sizeof(float);
    glNamedBufferStorage(s->row_buffer, (GLsizeiptr)row_bytes, row, GL_DYNAMIC_STORAGE_BIT);
    glNamedBufferStorage(s->column_buffer, (GLsizeiptr)column_bytes, column, 0);
    glNamedBufferStorage(s->place_buffer, (GLsizeiptr)place_bytes, NULL, 0);
    s->gpu_bytes += row_bytes + column_bytes + place_bytes;
    free(row);
    free(column);
}

static void make_vertex_array(struct spherical *s)
{
    glCreateVertexArrays(1, &s->vertex_array);
    glVertexArrayVertexBuffer(s->vertex_array, 0, s->place_buffer, 0, 3 * sizeof(float));
    glVertexArrayAttribFormat(s->vertex_array, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(s->vertex_array, 0, 0);
    glEnableVertexArrayAttrib(s->vertex_array, 0);
    glVertexArrayElementBuffer(s->vertex_array, s->index_buffer);
}

static status make_buffers(struct spherical *s, bool identify)
{
    gpu_context_forgive();
    glCreateBuffers(1, &s->row_buffer);
    glCreateBuffers(1, &s->column_buffer);
    glCreateBuffers(1, &s->place_buffer);
    glCreateBuffers(1, &s->index_buffer);
    glCreateBuffers(1, &s->cell_buffer);
    make_indices(s);
    make_rings(s);
    size_t work = ((size_t)s->cells + CELL_SECTORS) * 4 * sizeof(uint32_t);
    glNamedBufferStorage(s->cell_buffer, (GLsizeiptr)work, NULL, GL_DYNAMIC_STORAGE_BIT);
    s->gpu_bytes += work;
    if (identify) {
        glCreateBuffers(1, &s->stride_buffer);
        glNamedBufferStorage(s->stride_buffer, (GLsizeiptr)(s->cells * 4), NULL,
                             GL_DYNAMIC_STORAGE_BIT);
    }
    make_vertex_array(s);
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu MiB of ring geometry", s->gpu_bytes >> 20);
    return ERR_GPU;
}

static struct spherical *spherical_of(struct geometry *geometry)
{
    return (struct spherical *)geometry;
}

static const struct spherical *spherical_of_const(const struct geometry *geometry)
{
    return (const struct spherical *)geometry;
}

static void destroy(struct geometry *geometry)
{
    struct spherical *s = spherical_of(geometry);
    const GLuint buffers[] = {s->row_buffer,   s->column_buffer, s->place_buffer,
                              s->index_buffer, s->cell_buffer,   s->stride_buffer};
    glDeleteBuffers(6, buffers);
    glDeleteVertexArrays(1, &s->vertex_array);
    if (s->place_program) glDeleteProgram(s->place_program);
    if (s->mesh_program) glDeleteProgram(s->mesh_program);
    free(s->placed);
    free(s->draw_strides);
    free(s->thinned);
    free(s->work);
    free(s->counts);
    free(s->offsets);
    free(s->bases);
    free(s->drawn);
    free(s->strides);
    free(s);
}

static status create(const geometry_params *params, struct geometry **out)
{
    const perigee_view_params *v = params->view;
    struct spherical *s = NEW(struct spherical);
    s->rings = (ring_params){.azimuth_steps = v->azimuth_steps,
                             .rings_per_level = v->rings_per_level,
                             .levels = v->levels};
    s->spacing_px = v->ring_spacing_px;
    s->sharp = v->filter == PERIGEE_FILTER_SHARP;
    s->any_level = v->transform != PERIGEE_TRANSFORM_STABLE;
    s->plane = geo_is_plane(params->body);
    s->cull = !v->no_cull;
    s->cells = cell_count(&s->rings);
    size_t cells = (size_t)s->cells;
    s->placed = NEW_ARRAY(uint64_t, cells);
    s->strides = NEW_ARRAY(struct strides, cells);
    s->epoch = 1;
    s->thinned = NEW_ARRAY(float, 2 * (size_t)(CELL_BANDS * s->rings.levels));
    s->work = NEW_ARRAY(uint32_t, (cells + CELL_SECTORS) * 4);
    s->counts = NEW_ARRAY(GLsizei, cells);
    s->offsets = NEW_ARRAY(const void *, cells);
    s->bases = NEW_ARRAY(GLint, cells);
    s->drawn = NEW_ARRAY(int, cells);
    s->draw_strides = NEW_ARRAY(uint32_t, cells);
    char defines[512];
    snprintf(defines, sizeof defines, "%s#define FILL_RINGS %d\n#define BANDS %d\n",
             params->defines, CELL_FILL_RINGS, CELL_BANDS * s->rings.levels);
    status r = make_buffers(s, v->identify);
    if (!r) r = gpu_program_create_compute("place/place.comp", defines, &s->place_program);
    if (!r)
        r = gpu_program_create_render("mesh/mesh.vert", "mesh/mesh.frag", defines,
                                      &s->mesh_program);
    if (!r) *out = &s->base;
    else destroy(&s->base);
    return r;
}

static size_t gpu_bytes(const struct geometry *geometry)
{
    return spherical_of_const(geometry)->gpu_bytes;
}

static void invalidate(struct geometry *geometry)
{
    spherical_of(geometry)->epoch++;
}

// The finest level is that in whose fill the rings keep the spacing; no finer than the windows.
static double fill_rows(const struct geometry *geometry)
{
    return 4 * CELL_FILL_RINGS * fmax(spherical_of_const(geometry)->spacing_px, 4);
}

// The mesh begins at the horizon.
static void choose_levels(const struct geometry *geometry, const geometry_frame *f, int *first,
                          int *last)
{
    *last =
        projection_last_level(f->projection, f->gaze.distance, fill_rows(geometry), f->finest + 1);
    *first = projection_first_level(&f->view);
}

// The fill's rings stand at equal angles; so did those of the fill before, which began at the last
// level's first ring.
static void set_fill(const struct spherical *s, int last)
{
    ring_row rows[FILL_ROWS + BEFORE_ROWS];
    int first = ring_count(&s->rings);
    double outer = ring_angle(&s->rings, last * s->rings.rings_per_level), inner = outer / 2;
    for (int k = 0; k < FILL_ROWS; k++)
        rows[k] = row_at(s, inner * (1 - (double)k / CELL_FILL_RINGS));
    for (int k = 0; k < BEFORE_ROWS; k++)
        rows[FILL_ROWS + k] = row_at(s, outer * (1 - (double)(k + 1) / CELL_FILL_RINGS));
    glNamedBufferSubData(s->row_buffer, (GLintptr)((size_t)first * sizeof *rows), sizeof rows,
                         rows);
    glProgramUniform1ui(s->place_program, 1, (GLuint)first);
}

static void bind_vertices(const struct spherical *s)
{
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, s->place_buffer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, s->row_buffer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, s->column_buffer);
}

// One dispatch for each run of cells of one size.
static void place(struct spherical *s, uint32_t count, uint64_t *placed)
{
    if (!count) return;
    glNamedBufferSubData(s->cell_buffer, 0, (GLsizeiptr)(count * 4 * sizeof *s->work), s->work);
    glUseProgram(s->place_program);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s->cell_buffer);
    bind_vertices(s);
    for (uint32_t i = 0, run; i < count; i += run) {
        const uint32_t *w = s->work + 4 * (size_t)i;
        for (run = 1; i + run < count && w[4 * run + 1] == w[1]; run++) {
        }
        uint32_t vertices = (w[1] & 0xffff) * (w[3] & 0xffff);
        glUniform1ui(0, i);
        glDispatchCompute((vertices + 63) / 64, run, 1);
        *placed += (uint64_t)vertices * run;
    }
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

// What of the rings is drawn.
struct ring_draw {
    const cell_view *view;
    ring_sight sight;
    int first, last; // levels
    double newness; // of the last: 1 where it comes in, falling to 0. By that share it and the fill
                    // have slid onto the rings of the fill that was there before
};

struct selection {
    GLsizei draws;
    uint32_t work;
    uint64_t triangles;
    thinning columns;
};

static bool placed_by(const struct spherical *s, int cell, struct strides by)
{
    const struct strides *p = &s->strides[cell];
    return s->placed[cell] == s->epoch && p->rings <= by.rings && p->columns <= by.columns;
}

static uint32_t vertices_by(uint32_t vertices, int stride)
{
    return ((vertices - 1) / (uint32_t)stride + 1) | (uint32_t)stride << 16;
}

static void select_cell(struct spherical *s, int cell, const struct index_list *list,
                        struct strides by, struct selection *sel)
{
    cell_span v = cell_vertices(&s->rings, cell);
    s->counts[sel->draws] = list->count;
    s->offsets[sel->draws] = (const void *)(uintptr_t)list->offset;
    s->bases[sel->draws] = (GLint)(v.row * (uint32_t)ring_columns(&s->rings) + v.column);
    s->drawn[sel->draws] = cell;
    s->draw_strides[sel->draws] = (uint32_t)by.rings | (uint32_t)by.columns << 16;
    sel->draws++;
    sel->triangles += (uint64_t)list->count / 3;
    if (placed_by(s, cell, by)) return;
    s->placed[cell] = s->epoch;
    s->strides[cell] = by;
    uint32_t *w = s->work + 4 * sel->work++;
    w[0] = v.row;
    w[1] = vertices_by(v.rows, by.rings);
    w[2] = v.column;
    w[3] = vertices_by(v.columns, by.columns);
}

struct range {
    double low, high;
};

// By so much of the samples' range a sharpened height may exceed them: half of what the magnitudes
// of its weights (sharp_weights, shaders/lib/windows.glsl) come to above 1, ((1 + 4 * 0.2)^2 - 1)
// / 2.
#define SHARP_EXCESS 1.12

static struct range band_heights(const struct spherical *s, const struct windows *w, int level)
{
    struct range r, coarser;
    windows_height_bounds(w, level, &r.low, &r.high);
    for (int i = level - 1; s->any_level && i >= 0; i--) {
        windows_height_bounds(w, i, &coarser.low, &coarser.high);
        r.low = fmin(r.low, coarser.low);
        r.high = fmax(r.high, coarser.high);
    }
    double excess = s->sharp ? SHARP_EXCESS * (r.high - r.low) : 0;
    r.low -= excess;
    r.high += excess;
    return r;
}

static int log2_of(int stride)
{
    int k = 0;
    while (1 << k < stride) k++;
    return k;
}

// The bands whose ground a band may show: its own; while the last level is new its rings and the
// fill's slide over each other's.
static int bands_shown(const struct spherical *s, const struct ring_draw *d,
                       const struct range *heights, int level, int band, cell_band *out)
{
    const int fill = s->rings.levels, near[][2] = {{fill, 0}, {d->last, 0}, {d->last, 1}};
    bool sliding = d->newness > 0 && (level == d->last || level == fill);
    int count = sliding ? 3 : 1;
    for (int i = 0; i < count; i++) {
        int cell = sliding ? cell_index(near[i][0], near[i][1], 0) : cell_index(level, band, 0);
        out[i] = cell_band_of(&s->rings, d->view, cell, d->last, heights->low, heights->high);
    }
    return count;
}

static bool sector_visible(const struct ring_draw *d, const cell_band *bands, int count, int sector)
{
    for (int i = 0; i < count; i++)
        if (cell_band_visible(d->view, &bands[i], sector)) return true;
    return false;
}

static void select_band(struct spherical *s, const struct ring_draw *d, const struct range *heights,
                        int level, int band, struct selection *sel)
{
    bool fill = level == s->rings.levels;
    struct strides by = {1, sel->columns.stride};
    if (!fill) {
        thinning rings = thin_rings(&s->rings, &d->sight, level, band);
        float *thinned = s->thinned + 2 * (level * CELL_BANDS + band);
        by.rings = rings.stride;
        // A new level's rings do not slide onto each other while they are on those before.
        double new = level == d->last ? d->newness : 0;
        thinned[0] = (float)rings.stride;
        thinned[1] = (float)(fmax(0, rings.slid - new) / (1 - new));
    }
    const struct index_list *list =
        &s->lists[log2_of(by.columns)][fill ? STRIDE_COUNT : log2_of(by.rings)];
    cell_band shown[3];
    int count = s->cull ? bands_shown(s, d, heights, level, band, shown) : 0;
    for (int k = 0; k < CELL_SECTORS; k++)
        if (!s->cull || sector_visible(d, shown, count, k))
            select_cell(s, cell_index(level, band, k), list, by, sel);
}

static void select_levels(struct spherical *s, const struct windows *w, const struct ring_draw *d,
                          struct selection *sel)
{
    struct range heights = band_heights(s, w, d->last);
    select_band(s, d, &heights, s->rings.levels, 0, sel);
    for (int level = d->last; level >= d->first; level--) { // near to far
        heights = band_heights(s, w, level);
        for (int band = CELL_BANDS - 1; band >= 0; band--)
            select_band(s, d, &heights, level, band, sel);
    }
}

// The rings of the fill before, all around.
static void select_before(struct spherical *s, struct selection *sel)
{
    for (int k = 0; k < CELL_SECTORS; k++) {
        cell_span v = cell_vertices(&s->rings, cell_fill_index(&s->rings, k));
        const uint32_t one = 1u << 16;
        uint32_t *w = s->work + 4 * sel->work++;
        w[0] = v.row + FILL_ROWS;
        w[1] = BEFORE_ROWS | one;
        w[2] = v.column;
        w[3] = v.columns | one;
    }
}

// The fill stands inside the finest level, whose own height level changes with it.
static void place_fill_anew(struct spherical *s, int last)
{
    if (s->fill_of == last) return;
    set_fill(s, last);
    for (int k = 0; k < CELL_SECTORS; k++) s->placed[cell_fill_index(&s->rings, k)] = 0;
    invalidate(&s->base);
    s->fill_of = last;
}

// A finest level comes in over a fifth of an octave of distance.
static double newness_of(const struct spherical *s, const geometry_frame *f)
{
    const double comes_in = 0.2;
    double distance = f->gaze.distance, rows = fill_rows(&s->base);
    if (projection_last_level(f->projection, distance, rows, f->finest + 1) != f->last) return 0;
    double age = projection_last_level_age(f->projection, distance, rows, f->finest + 1);
    return fmax(0, 1 - fmax(age, 1e-6) / comes_in);
}

static struct ring_draw ring_draw_of(const struct spherical *s, const geometry_frame *f)
{
    const projection *p = f->projection;
    return (struct ring_draw){
        .view = &f->view,
        .newness = newness_of(s, f),
        .sight = {.radius = p->ellipsoid.a,
                  .altitude = p->camera.position.height,
                  .pixel = projection_pixel(p),
                  .spacing_px = s->spacing_px,
                  .gaze = f->gaze},
        .first = f->first,
        .last = f->last,
    };
}

// Chooses the visible cells, places those not placed yet (compute), and draws them all by one call.
static void draw(struct geometry *geometry, const geometry_frame *frame, geometry_counts *counts)
{
    struct spherical *s = spherical_of(geometry);
    struct ring_draw d = ring_draw_of(s, frame);
    place_fill_anew(s, d.last);
    double reach = projection_reach(&frame->view);
    struct selection sel = {.columns = thin_columns(&s->rings, &d.sight, reach, d.last)};
    select_levels(s, frame->windows, &d, &sel);
    if (d.newness > 0 && s->before_placed != s->epoch) select_before(s, &sel);
    if (d.newness > 0) s->before_placed = s->epoch;
    place(s, sel.work, &counts->vertices_placed);

    uint64_t per_level = (uint64_t)s->rings.azimuth_steps * (uint64_t)s->rings.rings_per_level * 2;
    counts->triangles_total = per_level * (uint64_t)(d.last - d.first + 1) +
                              (uint64_t)s->lists[0][STRIDE_COUNT].count / 3 * CELL_SECTORS;
    counts->triangles_drawn = sel.triangles;
    counts->draws = sel.draws > 0;
    if (s->stride_buffer) {
        glNamedBufferSubData(s->stride_buffer, 0, (GLsizeiptr)(sel.draws * 4), s->draw_strides);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s->stride_buffer);
    }
    glUseProgram(s->mesh_program);
    GLint fill = ring_count(&s->rings);
    glUniform4i(0, s->rings.rings_per_level / CELL_BANDS, fill, fill + FILL_ROWS,
                sel.columns.stride);
    glUniform2f(1, (float)sel.columns.slid, (float)d.newness);
    glUniform2fv(2, CELL_BANDS * s->rings.levels, s->thinned);
    bind_vertices(s);
    glBindVertexArray(s->vertex_array);
    if (sel.draws)
        glMultiDrawElementsBaseVertex(GL_TRIANGLES, s->counts, GL_UNSIGNED_INT,
                                      (const void *const *)s->offsets, sel.draws, s->bases);
}

static void identify(const struct geometry *geometry, uint32_t number, int *level, int *sector)
{
    const struct spherical *s = spherical_of_const(geometry);
    int cell = s->drawn[number];
    bool fill = cell_level(cell) == s->rings.levels;
    *level = fill ? s->fill_of + 1 : cell_level(cell);
    *sector = cell_sector(cell);
}

// Steps and rings with many divisors, or none could be left out; the spacing makes the size between
// them. The default itself is not among them.
static void resize(perigee_view_params *p, double size, uint64_t triangles)
{
    (void)triangles;
    perigee_view_params usual = {0};
    params_complete(&usual);
    int steps = 64;
    while (steps < usual.azimuth_steps * size && steps < 2048) steps *= 2;
    p->azimuth_steps = size == 1 ? usual.azimuth_steps : steps;
    p->rings_per_level = size == 1 ? usual.rings_per_level : steps * 3 / 32;
    p->ring_spacing_px = usual.ring_spacing_px / size;
    p->texels = params_texels_for(size);
}

const struct geometry_mode geometry_spherical = {
    .name = "spherical",
    .resize = resize,
    .create = create,
    .destroy = destroy,
    .gpu_bytes = gpu_bytes,
    .levels = choose_levels,
    .invalidate = invalidate,
    .draw = draw,
    .identify = identify,
};
