// Geometry clipmaps (Losasso & Hoppe 2004; Asirvatham & Hoppe 2005) over the map of longitude and
// latitude, wrapped onto the planet: nested squares of vertices about the focus, drawn as instances
// of a few footprints (planar_pieces.h).
//
// Watertight: a vertex has the same row and column terms (geo/nest.h) and the same height in every
// level that has it; at a level's border alpha is 1, and the border triangles close what the
// planet's curvature opens between an edge and the vertex over its middle.
//
// Wrapping is at odds with the poles: a square's columns draw together there, so that its ground
// gets narrow, and what lies beyond the pole is as far away on the map as half the map is wide. It
// is then drawn by the coarsest levels alone; the geometry says so once and in its counts.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/program.h"
#include "render/geometry.h"
#include "render/planar_cull.h"
#include "render/planar_elevation.h"
#include "render/planar_pieces.h"

struct instance {
    uint32_t row, column, level, number;
};

// Instances of one footprint, in the order in which they are drawn.
struct batch {
    int first, count;
};

enum { MAX_INSTANCES = CLIPMAP_MAX_LEVELS * (PLANAR_BLOCKS + PLANAR_PIECES) };

struct planar {
    struct geometry base;
    int n, levels;
    bool cull;
    bool stale, told; // tables are to be made again; the pole was spoken of
    planar_footprint piece[PLANAR_PIECES];
    struct planar_elevation *elevation;
    GLuint program, vertex_array;
    GLuint vertices, indices, instances, rows, columns, squares;
    size_t gpu_bytes;

    nest_square square[CLIPMAP_MAX_LEVELS];
    int first, last; // levels drawn last
    nest_row *row_table;
    nest_column *column_table;
    struct instance instance[MAX_INSTANCES];
    struct batch batch[PLANAR_PIECES];
    int count;
};

static struct planar *planar_of(struct geometry *geometry)
{
    return (struct planar *)geometry;
}

static const struct planar *planar_of_const(const struct geometry *geometry)
{
    return (const struct planar *)geometry;
}

static status complete(perigee_view_params *p)
{
    if (!p->planar_n) p->planar_n = p->texels - 1;
    if (!nest_size_valid(p->planar_n)) {
        log_error("impossible vertices across a square: %d (31, 63, 127, 255, 511 or 1023)",
                  p->planar_n);
        return ERR_ARGUMENT;
    }
    if (p->planar_n < p->texels) return OK;
    log_error("impossible vertices across a square: %d, more than the windows' %d height samples",
              p->planar_n, p->texels);
    return ERR_ARGUMENT;
}

static int table_stride(const struct planar *p)
{
    return p->n + 2;
}

static GLuint make_buffer(struct planar *p, size_t bytes, const void *data)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, data, data ? 0 : GL_DYNAMIC_STORAGE_BIT);
    p->gpu_bytes += bytes;
    return buffer;
}

static void make_vertex_array(struct planar *p)
{
    glCreateVertexArrays(1, &p->vertex_array);
    glVertexArrayVertexBuffer(p->vertex_array, 0, p->vertices, 0, 2 * sizeof(uint16_t));
    glVertexArrayVertexBuffer(p->vertex_array, 1, p->instances, 0, sizeof(struct instance));
    glVertexArrayAttribIFormat(p->vertex_array, 0, 2, GL_UNSIGNED_SHORT, 0);
    glVertexArrayAttribIFormat(p->vertex_array, 1, 4, GL_UNSIGNED_INT, 0);
    glVertexArrayBindingDivisor(p->vertex_array, 1, 1);
    for (GLuint i = 0; i < 2; i++) {
        glVertexArrayAttribBinding(p->vertex_array, i, i);
        glEnableVertexArrayAttrib(p->vertex_array, i);
    }
    glVertexArrayElementBuffer(p->vertex_array, p->indices);
}

static status make_buffers(struct planar *p)
{
    while (glGetError() != GL_NO_ERROR) {
    }
    planar_pieces pieces = planar_pieces_make(p->n);
    memcpy(p->piece, pieces.piece, sizeof p->piece);
    p->vertices = make_buffer(p, pieces.vertex_count * 2 * sizeof(uint16_t), pieces.vertices);
    p->indices = make_buffer(p, pieces.index_count * sizeof(uint16_t), pieces.indices);
    planar_pieces_free(&pieces);
    size_t table = (size_t)table_stride(p) * (size_t)p->levels;
    p->row_table = NEW_ARRAY(nest_row, table);
    p->column_table = NEW_ARRAY(nest_column, table);
    p->rows = make_buffer(p, table * sizeof(nest_row), NULL);
    p->columns = make_buffer(p, table * sizeof(nest_column), NULL);
    p->squares = make_buffer(p, CLIPMAP_MAX_LEVELS * 4 * sizeof(float), NULL);
    p->instances = make_buffer(p, sizeof p->instance, NULL);
    make_vertex_array(p);
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu MiB of footprints", p->gpu_bytes >> 20);
    return ERR_GPU;
}

static void destroy(struct geometry *geometry)
{
    struct planar *p = planar_of(geometry);
    const GLuint buffers[] = {p->vertices, p->indices, p->instances,
                              p->rows,     p->columns, p->squares};
    glDeleteBuffers(6, buffers);
    glDeleteVertexArrays(1, &p->vertex_array);
    if (p->program) glDeleteProgram(p->program);
    planar_elevation_destroy(&p->elevation);
    free(p->row_table);
    free(p->column_table);
    free(p);
}

static status create(const geometry_params *params, struct geometry **out)
{
    const perigee_view_params *v = params->view;
    struct planar *p = NEW(struct planar);
    p->n = v->planar_n;
    p->levels = v->levels;
    p->cull = !v->no_cull;
    p->stale = true;
    char defines[512];
    snprintf(defines, sizeof defines, "%s%s", params->defines,
             v->planar_packed ? "#define PACKED_HEIGHTS 1\n" : "");
    planar_elevation_params e = {p->n, p->levels, v->planar_packed, defines};
    status s = make_buffers(p);
    if (!s) s = planar_elevation_create(&e, &p->elevation);
    if (!s)
        s = gpu_program_create_render("planar/planar.vert", "mesh/mesh.frag", defines, &p->program);
    if (s) destroy(&p->base);
    else {
        p->gpu_bytes += planar_elevation_bytes(p->elevation);
        *out = &p->base;
    }
    return s;
}

static size_t gpu_bytes(const struct geometry *geometry)
{
    return planar_of_const(geometry)->gpu_bytes;
}

static void invalidate(struct geometry *geometry)
{
    planar_of(geometry)->stale = true;
}

static double seen_angle(const geometry_frame *f)
{
    return fmin(f->view.horizon + f->view.nadir_angle, M_PI);
}

static void choose_levels(const struct geometry *geometry, const geometry_frame *f, int *first,
                          int *last)
{
    const struct planar *p = planar_of_const(geometry);
    double share;
    *last =
        nest_finest_level(p->n, f->projection->ellipsoid.a, f->gaze.distance, p->levels, &share);
    *first = nest_coarsest_level(p->n, &f->projection->focus, seen_angle(f), p->levels);
}

// The squares of this frame. A level whose data are not all there is left out with all finer ones.
static void choose_squares(struct planar *p, const geometry_frame *f)
{
    const struct geo_focus *focus = &f->projection->focus;
    struct levels_block block;
    windows_fill_block(f->windows, &block);
    p->first = f->first;
    p->last = f->first;
    for (int i = f->first; i <= f->last; i++) {
        p->square[i] = nest_square_at(p->n, i, focus->lat, focus->lon);
        if (i > f->first && !planar_elevation_covered(f->windows, &block, &p->square[i])) break;
        p->last = i;
    }
}

static void fill_tables(struct planar *p, const struct geo_focus *focus)
{
    int stride = table_stride(p);
    for (int level = p->first; level <= p->last; level++) {
        const nest_square *s = &p->square[level];
        for (int i = 0; i < stride; i++) {
            p->row_table[level * stride + i] = nest_row_at(s, focus, i);
            p->column_table[level * stride + i] = nest_column_at(s, focus, i);
        }
    }
    size_t first = (size_t)(p->first * stride) * sizeof(nest_row),
           bytes = (size_t)((p->last - p->first + 1) * stride) * sizeof(nest_row);
    glNamedBufferSubData(p->rows, (GLintptr)first, (GLsizeiptr)bytes,
                         p->row_table + p->first * stride);
    glNamedBufferSubData(p->columns, (GLintptr)first, (GLsizeiptr)bytes,
                         p->column_table + p->first * stride);
}

// The finest level comes in over half a level, if it is the one that the height above ground asks
// for.
static void fill_squares(struct planar *p, const geometry_frame *f)
{
    float squares[CLIPMAP_MAX_LEVELS][4] = {{0}};
    double share;
    int finest =
        nest_finest_level(p->n, f->projection->ellipsoid.a, f->gaze.distance, p->levels, &share);
    for (int i = p->first; i <= p->last; i++) {
        squares[i][0] = (float)p->square[i].view_row;
        squares[i][1] = (float)p->square[i].view_column;
        squares[i][2] = i == finest ? (float)(1 - share) : 0;
        squares[i][3] = i > p->first;
    }
    glNamedBufferSubData(p->squares, 0, sizeof squares, squares);
}

static map_rect rect_of(const nest_square *s, int row, int column, int side)
{
    return (map_rect){.south = nest_latitude(s, row + side),
                      .north = nest_latitude(s, row),
                      .west = (column - s->view_column) * s->step,
                      .east = (column + side - s->view_column) * s->step};
}

static bool visible(const struct planar *p, const geometry_frame *f, int level, int row, int column,
                    int side)
{
    if (!p->cull) return true;
    map_rect rect = rect_of(&p->square[level], row, column, side);
    double low, high, pole_low, pole_high;
    windows_height_bounds(f->windows, level, &low, &high);
    if (fmax(fabs(rect.north), fabs(rect.south)) >= M_PI / 2) {
        windows_height_bounds(f->windows, 0, &pole_low, &pole_high);
        low = fmin(low, pole_low);
        high = fmax(high, pole_high);
    }
    return map_rect_visible(&f->view, rect, low, high);
}

static void add_instance(struct planar *p, int level, const int offset[2])
{
    struct instance *i = &p->instance[p->count];
    *i = (struct instance){(uint32_t)offset[0], (uint32_t)offset[1], (uint32_t)level,
                           (uint32_t)p->count};
    p->count++;
}

// Near to far, so that what is hidden is not shaded.
static void select_blocks(struct planar *p, const geometry_frame *f)
{
    int side = (p->n + 1) / 4 - 1;
    p->batch[PLANAR_BLOCK].first = p->count;
    for (int level = p->last; level >= p->first; level--) {
        int blocks = level == p->last ? PLANAR_BLOCKS : PLANAR_RING_BLOCKS;
        for (int k = blocks - 1; k >= 0; k--) {
            int offset[2];
            planar_block_offset(p->n, k, offset);
            if (visible(p, f, level, offset[0], offset[1], side)) add_instance(p, level, offset);
        }
    }
    p->batch[PLANAR_BLOCK].count = p->count - p->batch[PLANAR_BLOCK].first;
}

static enum planar_piece trim_of(const struct planar *p, int level)
{
    const nest_square *s = &p->square[level];
    nest_square finer = p->square[level + 1];
    int m = (p->n + 1) / 4;
    // The finer level leaves the row free on the side from which it keeps off.
    int row_last = finer.row / 2 - s->row == m - 1;
    int column_last = finer.column / 2 - s->column == m - 1;
    return (enum planar_piece)(PLANAR_TRIM + 2 * row_last + column_last);
}

static bool has_piece(const struct planar *p, int piece, int level)
{
    switch (piece) {
    case PLANAR_FIXUP:
        return true;
    case PLANAR_CROSS:
        return level == p->last;
    case PLANAR_BORDER:
        return level > p->first;
    case PLANAR_CLOSING:
        return level == 0;
    default:
        return level < p->last && (int)trim_of(p, level) == piece;
    }
}

static void select_pieces(struct planar *p, const geometry_frame *f)
{
    const int whole[2] = {0, 0};
    bool seen[CLIPMAP_MAX_LEVELS];
    for (int level = p->first; level <= p->last; level++)
        seen[level] = visible(p, f, level, 0, 0, level ? p->n - 1 : p->n + 1);
    for (int piece = PLANAR_FIXUP; piece < PLANAR_PIECES; piece++) {
        p->batch[piece].first = p->count;
        for (int level = p->last; level >= p->first; level--)
            if (seen[level] && has_piece(p, piece, level)) add_instance(p, level, whole);
        p->batch[piece].count = p->count - p->batch[piece].first;
    }
}

static void count_triangles(const struct planar *p, geometry_counts *counts)
{
    uint64_t side = (uint64_t)p->n - 1, all = 2 * side * side, levels = 0;
    for (int i = p->first; i <= p->last; i++) levels++;
    uint64_t hole = 2 * (uint64_t)(side / 2) * (side / 2);
    counts->triangles_total = levels * all - (levels - 1) * hole;
    for (int i = 0; i < PLANAR_PIECES; i++) {
        counts->triangles_drawn += (uint64_t)p->batch[i].count * p->piece[i].indices / 3;
        counts->draws += p->batch[i].count > 0;
    }
}

static void draw_batch(const struct planar *p, enum planar_piece i)
{
    const planar_footprint *piece = &p->piece[i];
    if (p->batch[i].count)
        glDrawElementsInstancedBaseVertexBaseInstance(
            GL_TRIANGLES, (GLsizei)piece->indices, GL_UNSIGNED_SHORT,
            (const void *)(uintptr_t)(piece->first_index * sizeof(uint16_t)), p->batch[i].count,
            (GLint)piece->first_vertex, (GLuint)p->batch[i].first);
}

static void draw_pieces(struct planar *p)
{
    float begin = (float)((p->n - 1) / 2 - nest_transition_width(p->n) - 1);
    glNamedBufferSubData(p->instances, 0, (GLsizeiptr)((size_t)p->count * sizeof *p->instance),
                         p->instance);
    glUseProgram(p->program);
    glUniform4f(0, (float)table_stride(p), begin, (float)(1 / nest_transition_width(p->n)),
                (float)(p->n - 1));
    glBindTextureUnit(7, planar_elevation_texture(p->elevation));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->rows);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, p->columns);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, p->squares);
    glBindVertexArray(p->vertex_array);
    for (int i = 0; i < PLANAR_PIECES; i++)
        if (i != PLANAR_BORDER) draw_batch(p, (enum planar_piece)i);
    // Drivers may tell the facing of a triangle by its corners and cover pixels by the corners
    // rounded: a sliver would be culled either way round.
    glDisable(GL_CULL_FACE);
    draw_batch(p, PLANAR_BORDER);
    glEnable(GL_CULL_FACE);
}

static void tell_of_pole(struct planar *p, bool pole)
{
    if (pole && !p->told)
        log_warn("planar: a pole is in sight; over the map of longitude and latitude the ground "
                 "there and beyond is drawn with the coarsest levels (--mode spherical has no "
                 "such place)");
    p->told |= pole;
}

static void draw(struct geometry *geometry, const geometry_frame *f, geometry_counts *counts)
{
    struct planar *p = planar_of(geometry);
    int first = p->first, last = p->last;
    choose_squares(p, f);
    if (p->stale || p->first != first || p->last != last) fill_tables(p, &f->projection->focus);
    p->stale = false;
    fill_squares(p, f);
    counts->vertices_placed +=
        planar_elevation_update(p->elevation, f->windows, p->square, p->first, p->last);
    p->count = 0;
    select_blocks(p, f);
    select_pieces(p, f);
    count_triangles(p, counts);
    counts->map_edge = nest_holds_pole(&f->projection->focus, seen_angle(f));
    tell_of_pole(p, counts->map_edge);
    draw_pieces(p);
}

// The sector: a block's number, 16 and on for the other footprints.
static void identify(const struct geometry *geometry, uint32_t number, int *level, int *sector)
{
    const struct planar *p = planar_of_const(geometry);
    *level = (int)p->instance[number].level;
    *sector = PLANAR_BLOCKS;
    for (int i = 0; i < PLANAR_PIECES; i++)
        if (p->batch[i].count && (int)number >= p->batch[i].first) *sector = PLANAR_BLOCKS - 1 + i;
    int offset[2];
    for (int k = 0; (int)number < p->batch[PLANAR_BLOCK].count && k < PLANAR_BLOCKS; k++) {
        planar_block_offset(p->n, k, offset);
        if (p->instance[number].row == (uint32_t)offset[0] &&
            p->instance[number].column == (uint32_t)offset[1])
            *sector = k;
    }
}

const struct geometry_mode geometry_planar = {
    .name = "planar",
    .complete = complete,
    .create = create,
    .destroy = destroy,
    .gpu_bytes = gpu_bytes,
    .levels = choose_levels,
    .invalidate = invalidate,
    .draw = draw,
    .identify = identify,
};
