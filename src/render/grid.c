// The persistent grid: index and vertex buffers of one size for good; the vertices are thrown onto
// the planet and lifted by two compute passes whenever the camera or the heights change. Nothing is
// culled: the grid covers what can be seen and little else (geo/screen_grid.h).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "geo/screen_grid.h"
#include "gpu/context.h"
#include "gpu/program.h"
#include "render/geometry.h"
#include "render/params.h"

enum { SIDE_MAX = 4096, VERTICES_MAX = 1 << 22, DEFAULT_ROWS = 360, DEFAULT_COLUMNS = 480 };

#define BENEATH_M 0.5
#define PICTURES  4

// What the placed vertices depend on, besides the heights.
struct sight {
    geo_camera camera;
    double focus_lat, focus_lon, aspect;
};

struct grid {
    struct geometry base;
    double denser;
    grid_params params;
    struct grid_block block;
    struct grid_column *columns;
    GLuint block_buffer, column_buffer, ring_buffer, place_buffer, index_buffer, vertex_array;
    GLuint throw_program, lift_program, mesh_program;
    struct sight placed; // for which the vertices stand
    bool stale, any;     // they do not; there is something to draw
    size_t gpu_bytes;
};

static status complete(perigee_view_params *p)
{
    if (!p->grid_rows && !p->grid_columns) {
        p->grid_rows = DEFAULT_ROWS;
        p->grid_columns = DEFAULT_COLUMNS;
    }
    if (p->grid_rows < 2 || p->grid_columns < 2 || p->grid_rows > SIDE_MAX ||
        p->grid_columns > SIDE_MAX) {
        log_error("impossible grid: %d x %d vertices (2 to %d each)", p->grid_rows, p->grid_columns,
                  SIDE_MAX);
        return ERR_ARGUMENT;
    }
    if (p->grid_rows * p->grid_columns > VERTICES_MAX) {
        log_error("impossible grid: %d x %d vertices are more than %d", p->grid_rows,
                  p->grid_columns, VERTICES_MAX);
        return ERR_ARGUMENT;
    }
    if (!(p->grid_denser >= 0 && p->grid_denser <= 0.9)) {
        log_error("impossible density of the grid's middle: %g (0 to 0.9)", p->grid_denser);
        return ERR_ARGUMENT;
    }
    return OK;
}

static void resize(perigee_view_params *p, double size, uint64_t triangles)
{
    (void)triangles;
    size = fmin(size, sqrt((double)VERTICES_MAX / (DEFAULT_ROWS * DEFAULT_COLUMNS)));
    p->grid_rows = (int)fmax(2, floor(size * DEFAULT_ROWS));
    p->grid_columns = (int)fmax(2, floor(size * DEFAULT_COLUMNS));
    p->texels = params_texels_for(size);
}

static struct grid *grid_of(struct geometry *geometry)
{
    return (struct grid *)geometry;
}

static const struct grid *grid_of_const(const struct geometry *geometry)
{
    return (const struct grid *)geometry;
}

static size_t vertex_count(const struct grid *g)
{
    return (size_t)g->params.rows * (size_t)g->params.columns;
}

static GLsizei index_count(const struct grid *g)
{
    return 6 * (g->params.rows - 1) * (g->params.columns - 1);
}

// Two triangles a quad, counter-clockwise on the screen. The last vertex of both is the lower left,
// by which mesh.frag tells a quad from all others.
static void write_indices(const struct grid *g, uint32_t *out)
{
    uint32_t columns = (uint32_t)g->params.columns;
    for (uint32_t row = 0; row + 1 < (uint32_t)g->params.rows; row++) {
        for (uint32_t column = 0; column + 1 < columns; column++) {
            uint32_t low = row * columns + column, high = low + columns;
            *out++ = low + 1;
            *out++ = high + 1;
            *out++ = low;
            *out++ = high + 1;
            *out++ = high;
            *out++ = low;
        }
    }
}

static GLuint make_buffer(struct grid *g, size_t bytes, const void *data, GLbitfield flags)
{
    GLuint b;
    glCreateBuffers(1, &b);
    glNamedBufferStorage(b, (GLsizeiptr)bytes, data, flags);
    g->gpu_bytes += bytes;
    return b;
}

static void make_vertex_array(struct grid *g)
{
    glCreateVertexArrays(1, &g->vertex_array);
    const GLuint buffers[2] = {g->place_buffer, g->ring_buffer};
    for (GLuint i = 0; i < 2; i++) {
        glVertexArrayVertexBuffer(g->vertex_array, i, buffers[i], 0, 3 * sizeof(float));
        glVertexArrayAttribFormat(g->vertex_array, i, 3, GL_FLOAT, GL_FALSE, 0);
        glVertexArrayAttribBinding(g->vertex_array, i, i);
        glEnableVertexArrayAttrib(g->vertex_array, i);
    }
    glVertexArrayElementBuffer(g->vertex_array, g->index_buffer);
}

static status make_buffers(struct grid *g)
{
    gpu_context_forgive();
    size_t columns = (size_t)g->params.columns, vertices = 3 * vertex_count(g) * sizeof(float),
           index_bytes = (size_t)index_count(g) * sizeof(uint32_t);
    uint32_t *indices = malloc(index_bytes);
    if (!indices) {
        log_error("no memory for a grid of %d x %d vertices", g->params.rows, g->params.columns);
        return ERR_MEMORY;
    }
    write_indices(g, indices);
    g->block_buffer = make_buffer(g, sizeof g->block, NULL, GL_DYNAMIC_STORAGE_BIT);
    g->column_buffer = make_buffer(g, columns * sizeof *g->columns, NULL, GL_DYNAMIC_STORAGE_BIT);
    g->ring_buffer = make_buffer(g, vertices, NULL, 0);
    g->place_buffer = make_buffer(g, vertices, NULL, 0);
    g->index_buffer = make_buffer(g, index_bytes, indices, 0);
    free(indices);
    make_vertex_array(g);
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu MiB for a grid of %d x %d vertices", g->gpu_bytes >> 20,
              g->params.rows, g->params.columns);
    return ERR_GPU;
}

static void destroy(struct geometry *geometry)
{
    struct grid *g = grid_of(geometry);
    const GLuint buffers[] = {g->block_buffer, g->column_buffer, g->ring_buffer, g->place_buffer,
                              g->index_buffer};
    const GLuint programs[] = {g->throw_program, g->lift_program, g->mesh_program};
    glDeleteBuffers(5, buffers);
    glDeleteVertexArrays(1, &g->vertex_array);
    for (int i = 0; i < 3; i++)
        if (programs[i]) glDeleteProgram(programs[i]);
    free(g->columns);
    free(g);
}

static status create(const geometry_params *params, struct geometry **out)
{
    const perigee_view_params *v = params->view;
    struct grid *g = NEW(struct grid);
    g->params.rows = v->grid_rows;
    g->params.columns = v->grid_columns;
    g->denser = v->grid_denser;
    g->columns = NEW_ARRAY(struct grid_column, (size_t)v->grid_columns);
    g->stale = true;
    char defines[256];
    snprintf(defines, sizeof defines, "%s%s", params->defines,
             v->grid_farthest ? "#define FARTHEST_NEIGHBOUR 1\n" : "");
    status s = make_buffers(g);
    if (!s) s = gpu_program_create_compute("grid/throw.comp", params->defines, &g->throw_program);
    if (!s) s = gpu_program_create_compute("grid/lift.comp", defines, &g->lift_program);
    if (!s)
        s = gpu_program_create_render("grid/grid.vert", "mesh/mesh.frag", params->defines,
                                      &g->mesh_program);
    if (!s) *out = &g->base;
    else destroy(&g->base);
    return s;
}

static size_t gpu_bytes(const struct geometry *geometry)
{
    return grid_of_const(geometry)->gpu_bytes;
}

static void invalidate(struct geometry *geometry)
{
    grid_of(geometry)->stale = true;
}

// Up to samples of a pixel's width.
static void choose_levels(const struct geometry *geometry, const geometry_frame *f, int *first,
                          int *last)
{
    (void)geometry;
    *last = projection_last_level(f->projection, f->gaze.distance, 256, CLIPMAP_MAX_LEVELS);
    *first = projection_first_level(&f->view);
}

// The hierarchy of heights: a level's disc about the focus holds one about the camera.
static void set_discs(struct grid *g, const geometry_frame *f)
{
    grid_params *p = &g->params;
    p->disc_count = 0;
    for (int i = 0; i <= f->last && i < GRID_DISCS_MAX; i++) {
        double low, high, angle = ldexp(M_PI, -i),
                          reach = geo_is_plane(p->ellipsoid) ? ring_plane_radius(angle) : angle;
        double radius = reach - (i ? f->view.nadir_angle : 0);
        if (radius <= 0) break;
        windows_height_bounds(f->windows, i, &low, &high);
        p->discs[p->disc_count++] = (grid_disc){radius, low, high};
    }
    // A camera beneath the ground, while data is late or because it was sent there, sees the ground
    // from below.
    double beneath = p->camera.position.height - BENEATH_M;
    for (int i = 0; i < p->disc_count; i++) p->discs[i].low = fmin(p->discs[i].low, beneath);
    for (int i = p->disc_count - 2; i >= 0; i--) {
        p->discs[i].low = fmin(p->discs[i].low, p->discs[i + 1].low);
        p->discs[i].high = fmax(p->discs[i].high, p->discs[i + 1].high);
    }
}

// A narrow picture's ground: the lowest in the disc about the focus that is some pictures wide.
static double ground_of(const geometry_frame *f)
{
    if (!f->gaze.aside) return NAN;
    const projection *p = f->projection;
    double low, high, aspect = (double)p->width / p->height,
                      wide = PICTURES * f->gaze.distance * tan(p->camera.fov_y / 2) *
                             hypot(1, aspect) / p->ellipsoid.a;
    int level = (int)clamp_double(floor(log2(M_PI / wide)), 0, f->last);
    windows_height_bounds(f->windows, level, &low, &high);
    return fmin(low, p->camera.position.height - BENEATH_M);
}

static struct sight sight_of(const geometry_frame *f)
{
    const projection *p = f->projection;
    struct sight s;
    memset(&s, 0, sizeof s);
    s.camera = p->camera;
    s.focus_lat = p->focus.lat;
    s.focus_lon = p->focus.lon;
    s.aspect = (double)p->width / p->height;
    return s;
}

static void place(struct grid *g, const geometry_frame *f)
{
    grid_params *p = &g->params;
    p->ellipsoid = f->projection->ellipsoid;
    p->camera = f->projection->camera;
    p->aspect = (double)f->projection->width / f->projection->height;
    // Of the widest views the ground around the camera, a few pixels in the middle, is most.
    p->denser = fmax(g->denser, 1 - tan(PROJECTION_WIDE_FOV / 2) / tan(p->camera.fov_y / 2));
    p->focus = &f->projection->focus;
    set_discs(g, f);
    p->ground_m = ground_of(f);
    g->any = grid_make(p, &g->block, g->columns);
    p->focus = NULL;
    if (!g->any) return;
    glNamedBufferSubData(g->block_buffer, 0, sizeof g->block, &g->block);
    glNamedBufferSubData(g->column_buffer, 0, (GLsizeiptr)((size_t)p->columns * sizeof *g->columns),
                         g->columns);
    const GLuint buffers[4] = {g->block_buffer, g->column_buffer, g->ring_buffer, g->place_buffer};
    for (GLuint i = 0; i < 4; i++) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]);
    GLuint groups = (GLuint)((vertex_count(g) + 63) / 64);
    glUseProgram(g->throw_program);
    glUniform2i(0, p->rows, p->columns);
    glDispatchCompute(groups, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glUseProgram(g->lift_program);
    glUniform2i(0, p->rows, p->columns);
    glDispatchCompute(groups, 1, 1);
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
}

static void draw(struct geometry *geometry, const geometry_frame *frame, geometry_counts *counts)
{
    struct grid *g = grid_of(geometry);
    struct sight sight = sight_of(frame);
    if (g->stale || memcmp(&sight, &g->placed, sizeof sight)) {
        place(g, frame);
        g->placed = sight;
        g->stale = false;
        counts->vertices_placed += g->any ? vertex_count(g) : 0;
    }
    counts->triangles_total = (uint64_t)index_count(g) / 3;
    counts->triangles_drawn = g->any ? counts->triangles_total : 0;
    counts->draws = g->any;
    if (!g->any) return;
    glUseProgram(g->mesh_program);
    glUniform1i(0, g->params.columns);
    glBindVertexArray(g->vertex_array);
    glDrawElements(GL_TRIANGLES, index_count(g), GL_UNSIGNED_INT, NULL);
}

// One draw, without levels or sectors of its own.
static void identify(const struct geometry *geometry, uint32_t number, int *level, int *sector)
{
    (void)geometry;
    (void)number;
    *level = 0;
    *sector = 0;
}

const struct geometry_mode geometry_grid = {
    .name = "grid",
    .outside = true,
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
