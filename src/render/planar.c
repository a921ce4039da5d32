// Geometry clipmaps (Losasso & Hoppe 2004; Asirvatham & Hoppe 2005) over the map of longitude and
// latitude, wrapped onto the planet: nested squares of vertices about the focus, in one of two
// forms (planar_footprints.c, planar_rectangles.c).
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
#include "gpu/context.h"
#include "gpu/program.h"
#include "render/planar_parts.h"

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
    if (p->planar_n >= p->texels) {
        log_error("impossible vertices across a square: %d, more than the windows' %d height "
                  "samples",
                  p->planar_n, p->texels);
        return ERR_ARGUMENT;
    }
    if ((int)p->planar_form < 0 || p->planar_form > PERIGEE_PLANAR_2004) {
        log_error("impossible form of the planar mode: %d", (int)p->planar_form);
        return ERR_ARGUMENT;
    }
    if (p->planar_memory_free && p->planar_form == PERIGEE_PLANAR_2004) {
        log_error("synthesis without memory: only the planar form of 2005 draws level by level");
        return ERR_ARGUMENT;
    }
    if (!p->planar_triangles || p->planar_form == PERIGEE_PLANAR_2004) return OK;
    log_error("a bound of %u triangles: only the planar form of 2004 can keep one",
              (unsigned)p->planar_triangles);
    return ERR_ARGUMENT;
}

// The squares of the next size, cut by the form of 2004 to the triangles of the size wanted.
static void resize(perigee_view_params *p, double size, uint64_t triangles)
{
    const int default_n = 255;
    int n = NEST_N_MIN;
    while (n < NEST_N_MAX && n + 1 < size * (default_n + 1) * 0.999) n = 2 * n + 1;
    p->planar_n = n;
    p->texels = n < 127 ? 128 : n + 1;
    p->planar_form = PERIGEE_PLANAR_2004;
    p->planar_memory_free = p->planar_residuals = false;
    p->planar_triangles = (uint32_t)fmin((double)triangles * size * size, UINT32_MAX);
}

static int table_stride(const struct planar *p)
{
    return p->n + 2;
}

GLuint planar_vertex_array(GLuint vertices, GLuint instances, GLuint indices)
{
    GLuint a;
    glCreateVertexArrays(1, &a);
    glVertexArrayVertexBuffer(a, 0, vertices, 0, 2 * sizeof(uint16_t));
    glVertexArrayVertexBuffer(a, 1, instances, 0, 4 * sizeof(uint32_t));
    glVertexArrayAttribIFormat(a, 0, 2, GL_UNSIGNED_SHORT, 0);
    glVertexArrayAttribIFormat(a, 1, 4, GL_UNSIGNED_INT, 0);
    glVertexArrayBindingDivisor(a, 1, 1);
    for (GLuint i = 0; i < 2; i++) {
        glVertexArrayAttribBinding(a, i, i);
        glEnableVertexArrayAttrib(a, i);
    }
    glVertexArrayElementBuffer(a, indices);
    return a;
}

static GLuint make_buffer(struct planar *p, size_t bytes)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_STORAGE_BIT);
    p->gpu_bytes += bytes;
    return buffer;
}

// As planar.vert has it.
struct square_block {
    float viewer[4], active[4], blend[4];
};

static status make_tables(struct planar *p)
{
    size_t table = (size_t)table_stride(p) * (size_t)p->levels;
    gpu_context_forgive();
    p->row_table = NEW_ARRAY(nest_row, table);
    p->column_table = NEW_ARRAY(nest_column, table);
    p->rows = make_buffer(p, table * sizeof(nest_row));
    p->columns = make_buffer(p, table * sizeof(nest_column));
    p->squares = make_buffer(p, CLIPMAP_MAX_LEVELS * sizeof(struct square_block));
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu KiB of tables", p->gpu_bytes >> 10);
    return ERR_GPU;
}

static void destroy(struct geometry *geometry)
{
    struct planar *p = planar_of(geometry);
    const GLuint buffers[] = {p->rows, p->columns, p->squares};
    glDeleteBuffers(3, buffers);
    if (p->program) glDeleteProgram(p->program);
    planar_footprints_destroy(&p->footprints);
    planar_rectangles_destroy(&p->rectangles);
    planar_elevation_destroy(&p->elevation);
    free(p->row_table);
    free(p->column_table);
    free(p);
}

static status create(const geometry_params *params, struct geometry **out)
{
    const perigee_view_params *v = params->view;
    struct planar *p = NEW(struct planar);
    p->form = v->planar_form;
    p->n = v->planar_n;
    p->plane = geo_is_plane(params->body);
    p->levels = v->levels + (p->plane ? NEST_PLANE_LEVELS : 0);
    if (p->levels > CLIPMAP_MAX_LEVELS) p->levels = CLIPMAP_MAX_LEVELS;
    p->kept = planar_elevation_kept(params->windows, p->levels, p->plane);
    p->most_triangles = v->planar_triangles;
    p->cull = !v->no_cull;
    p->stale = true;
    char defines[512], kept[40] = "";
    if (p->kept < p->levels) snprintf(kept, sizeof kept, "#define KEPT_ELEVATIONS %d\n", p->kept);
    snprintf(defines, sizeof defines, "%s%s%s", params->defines, kept,
             v->planar_packed ? "#define PACKED_HEIGHTS 1\n" : "");
    planar_elevation_params e = {p->n, p->levels, p->kept, v->planar_packed, defines};
    status s = make_tables(p);
    if (!s)
        s = p->form == PERIGEE_PLANAR_2004 ? planar_rectangles_create(p, &p->rectangles)
                                           : planar_footprints_create(p, &p->footprints);
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
    double angle = f->view.horizon + f->view.nadir_angle;
    return geo_is_plane(f->view.ellipsoid) ? angle : fmin(angle, M_PI);
}

static int finest_level(const struct planar *p, const geometry_frame *f, double *share)
{
    int wider = p->plane ? NEST_PLANE_LEVELS : 0;
    return wider + nest_finest_level(p->n, f->projection->ellipsoid.a, f->gaze.distance,
                                     p->levels - wider, share);
}

static void choose_levels(const struct geometry *geometry, const geometry_frame *f, int *first,
                          int *last)
{
    const struct planar *p = planar_of_const(geometry);
    double share;
    *last = finest_level(p, f, &share);
    *first = nest_coarsest_level(p->n, &f->projection->focus, seen_angle(f), p->levels);
}

// The squares of this frame, and how far their data reach.
static void choose_squares(struct planar *p, const geometry_frame *f)
{
    const struct geo_focus *focus = &f->projection->focus;
    struct levels_block block;
    windows_fill_block(f->windows, &block);
    for (int i = f->first; i <= f->last; i++) {
        p->square[i] = nest_square_over(focus->ellipsoid, p->n, i, focus->lat, focus->lon);
        p->clip[i] = planar_elevation_clip(f->windows, &block, &p->square[i]);
    }
    p->first = f->first;
}

// 2005, 2.3.1: a level whose data are not all there is left out with all finer ones.
static void choose_whole_levels(struct planar *p, const geometry_frame *f)
{
    p->last = p->first;
    for (int i = f->first; i <= f->last; i++) {
        planar_region all = planar_region_wanted(&p->square[i], 1), clip = p->clip[i];
        bool whole = clip.row0 <= all.row0 && clip.row1 >= all.row1 &&
                     clip.column0 <= all.column0 && clip.column1 >= all.column1;
        if (i > f->first && !whole) break;
        p->active[i] = all;
        p->last = i;
    }
}

// What is not kept is drawn level by level.
static void choose_together(struct planar *p)
{
    p->together = p->kept - 1 < p->last ? p->kept - 1 : p->last;
    if (p->together < p->first) p->together = p->first;
}

// The whole circle of the map closes.
static void close_circle(struct planar *p)
{
    if (p->first == 0 && !p->plane) p->active[0].column1 = p->n + 1;
}

// 2004, 5 and 6.1; with a bound of triangles the regions of all but the coarsest level shrink until
// it is kept, or they are as small as can be.
static void choose_regions(struct planar *p, const geometry_frame *f)
{
    enum { TRIES = 8 };
    double share = 1;
    for (int i = 0; i < TRIES; i++) {
        planar_region clip[CLIPMAP_MAX_LEVELS];
        memcpy(clip, p->clip, sizeof clip);
        p->last = planar_regions_crop(p->square, f->first, f->last, share, clip, p->active);
        close_circle(p);
        uint64_t triangles = planar_rectangles_select(p->rectangles, p, f);
        if (!p->most_triangles || triangles <= p->most_triangles) return;
        share *= fmin(0.95, sqrt((double)p->most_triangles / (double)triangles));
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
    struct square_block blocks[CLIPMAP_MAX_LEVELS] = {0};
    double share;
    int finest = finest_level(p, f, &share);
    for (int i = p->first; i <= p->last; i++) {
        struct square_block *b = &blocks[i];
        planar_region a = p->active[i], finer = {0};
        if (i < p->last)
            finer = planar_region_in_coarser(&p->square[i + 1], &p->square[i], p->active[i + 1]);
        double width = planar_region_transition(p->n, a, finer);
        double begin = planar_region_begin(&p->square[i], a, finer);
        const float viewer[4] = {(float)p->square[i].view_row, (float)p->square[i].view_column,
                                 i == finest ? (float)(1 - share) : 0, i > p->first};
        const float active[4] = {(float)a.row0, (float)a.row1, (float)a.column0, (float)a.column1};
        const float blend[4] = {(float)begin, (float)(1 / width), 0, 0};
        memcpy(b->viewer, viewer, sizeof viewer);
        memcpy(b->active, active, sizeof active);
        memcpy(b->blend, blend, sizeof blend);
    }
    glNamedBufferSubData(p->squares, 0, sizeof blocks, blocks);
}

bool planar_visible(const struct planar *p, const geometry_frame *f, int level, planar_region r)
{
    if (!p->cull) return true;
    const nest_square *s = &p->square[level];
    map_rect rect = {.south = nest_latitude(s, r.row1),
                     .north = nest_latitude(s, r.row0),
                     .west = (r.column0 - s->view_column) * s->step,
                     .east = (r.column1 - s->view_column) * s->step};
    double low, high, pole_low, pole_high;
    windows_height_bounds(f->windows, planar_height_level(s), &low, &high);
    if (!p->plane && fmax(fabs(rect.north), fabs(rect.south)) >= M_PI / 2) {
        windows_height_bounds(f->windows, 0, &pole_low, &pole_high);
        low = fmin(low, pole_low);
        high = fmax(high, pole_high);
    }
    return map_rect_visible(&f->view, rect, low, high);
}

// Before culling.
static uint64_t all_triangles(const struct planar *p)
{
    uint64_t sum = 0;
    for (int i = p->first; i <= p->last; i++) {
        planar_region parts[4], finer = {0};
        if (i < p->last)
            finer = planar_region_in_coarser(&p->square[i + 1], &p->square[i], p->active[i + 1]);
        int count = planar_region_frame(p->active[i], finer, parts);
        for (int k = 0; k < count; k++)
            sum += 2 * (uint64_t)(parts[k].row1 - parts[k].row0) *
                   (uint64_t)(parts[k].column1 - parts[k].column0);
    }
    return sum;
}

static void tell_of_pole(struct planar *p, bool pole)
{
    if (pole && !p->told)
        log_warn("planar: a pole is in sight; over the map of longitude and latitude the ground "
                 "there and beyond is drawn with the coarsest levels (--mode spherical has no "
                 "such place)");
    p->told |= pole;
}

static void draw_levels(struct planar *p, const geometry_frame *f, int first, int last,
                        geometry_counts *counts)
{
    counts->vertices_placed +=
        planar_elevation_update(p->elevation, f->windows, p->square, p->first, first, last);
    glUseProgram(p->program);
    glUniform1ui(0, (GLuint)table_stride(p));
    glUniform1ui(1, (GLuint)((p->n + 2) * (p->n + 2) + (1 << 17)));
    glBindTextureUnit(7, planar_elevation_texture(p->elevation));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p->rows);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, p->columns);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, p->squares);
    if (p->rectangles) planar_rectangles_draw(p->rectangles, p, counts);
    else planar_footprints_draw(p->footprints, last - p->together, counts);
}

static void draw(struct geometry *geometry, const geometry_frame *f, geometry_counts *counts)
{
    struct planar *p = planar_of(geometry);
    int first = p->first, last = p->last;
    choose_squares(p, f);
    if (p->rectangles) {
        choose_regions(p, f);
    } else {
        choose_whole_levels(p, f);
        close_circle(p);
        choose_together(p);
        planar_footprints_select(p->footprints, p, f);
    }
    if (p->stale || p->first != first || p->last != last) fill_tables(p, &f->projection->focus);
    p->stale = false;
    fill_squares(p, f);
    counts->triangles_total = all_triangles(p);
    counts->map_edge = nest_holds_pole(&f->projection->focus, seen_angle(f));
    tell_of_pole(p, counts->map_edge);

    int last_together = p->rectangles ? p->last : p->together;
    windows_begin_sweep(f->windows);
    draw_levels(p, f, p->first, last_together, counts);
    for (int i = last_together + 1; i <= p->last; i++) draw_levels(p, f, i, i, counts);
}

static void identify(const struct geometry *geometry, uint32_t number, int *level, int *sector)
{
    const struct planar *p = planar_of_const(geometry);
    if (p->footprints) {
        planar_footprints_identify(p->footprints, number, level, sector);
        return;
    }
    *level = (int)number / 2;
    *sector = (int)number % 2;
}

const struct geometry_mode geometry_planar = {
    .name = "planar",
    .complete = complete,
    .resize = resize,
    .create = create,
    .destroy = destroy,
    .gpu_bytes = gpu_bytes,
    .levels = choose_levels,
    .invalidate = invalidate,
    .draw = draw,
    .identify = identify,
};
