// Positions on the noise's lattice need double precision (zoom 24 has 2^30 cells around the globe):
// the CPU gives each row and column of the rectangle its share of them, the GPU multiplies.
#include "render/deepen.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "gpu/context.h"
#include "gpu/program.h"
#include "planet/region.h"

// As in deepen.comp, std430.
struct row {
    double scale;
    uint32_t hz;
    float z, sin_lat, cos_lat, shape[2], weight[4], factor[4];
};

struct column {
    double cos_lon, sin_lon;
};

struct slot {
    size_t range; // bytes into the buffer of ranges
    GLsync fence;
    clipmap_strip strip;
};

enum { SLOTS = 48, DEEPEN_MAX_SIDE = 2048 };

// What the texels of a level stand for in the tables of rows and columns; -1: nothing yet.
struct table {
    int64_t rows[DEEPEN_MAX_SIDE], columns[DEEPEN_MAX_SIDE];
};

struct deepen {
    struct pyramid *pyramid;
    window_shape shape;
    GLuint program, range_program, rows, columns, ranges;
    const unsigned char *map; // of ranges
    size_t row_stride, column_stride, range_bytes, bytes;
    struct table *tables; // by level
    struct row *row;      // room for new entries
    struct column *column;
    struct slot slots[SLOTS];
    int first, busy; // slots in use, oldest first
};

static size_t aligned(size_t bytes)
{
    GLint align = 256;
    glGetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &align);
    return (bytes + (size_t)align - 1) / (size_t)align * (size_t)align;
}

static GLuint make_buffer(size_t bytes, GLbitfield flags)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)bytes, NULL, flags);
    return buffer;
}

// Ranges have room for a strip in each slot: as many rows as a strip may have.
static status make_buffers(struct deepen *d, int levels, int max_rows)
{
    GLbitfield read = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    size_t cells = (size_t)max_rows * (size_t)(d->shape.cols / CLIP_CELL);
    gpu_context_forgive();
    d->row_stride = aligned((size_t)d->shape.rows * sizeof(struct row));
    d->column_stride = aligned((size_t)d->shape.cols * sizeof(struct column));
    size_t slot = aligned(cells * sizeof(clip_range));
    for (int i = 0; i < SLOTS; i++) d->slots[i].range = slot * (size_t)i;
    d->rows = make_buffer(d->row_stride * (size_t)levels, GL_DYNAMIC_STORAGE_BIT);
    d->columns = make_buffer(d->column_stride * (size_t)levels, GL_DYNAMIC_STORAGE_BIT);
    d->ranges = make_buffer(slot * SLOTS, read);
    d->map = glMapNamedBufferRange(d->ranges, 0, (GLsizeiptr)(slot * SLOTS), read);
    d->bytes = (d->row_stride + d->column_stride) * (size_t)levels + slot * SLOTS;
    if (d->map && glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu KiB for levels below the data", d->bytes >> 10);
    return ERR_GPU;
}

status deepen_create(struct pyramid *pyramid, const window_shape *shape, int levels, int max_rows,
                     const char *defines, struct deepen **out)
{
    assert(shape->rows <= DEEPEN_MAX_SIDE && shape->cols <= DEEPEN_MAX_SIDE);
    struct deepen *d = NEW(struct deepen);
    bool eroded = pyramid_synthesis(pyramid) == SYNTHESIS_ERODED;
    d->pyramid = pyramid;
    d->shape = *shape;
    d->tables = NEW_ARRAY(struct table, (size_t)levels);
    memset(d->tables, 0xff, sizeof *d->tables * (size_t)levels);
    d->row = NEW_ARRAY(struct row, (size_t)shape->rows);
    d->column = NEW_ARRAY(struct column, (size_t)shape->cols);
    char text[64];
    snprintf(text, sizeof text, "%s%s", defines ? defines : "", eroded ? "#define ERODED\n" : "");
    status s = make_buffers(d, levels, max_rows);
    if (!s) s = gpu_program_create_compute("deepen/deepen.comp", text, &d->program);
    if (!s) s = gpu_program_create_compute("deepen/ranges.comp", NULL, &d->range_program);
    if (s) deepen_destroy(&d);
    *out = d;
    return s;
}

void deepen_destroy(struct deepen **deepen)
{
    struct deepen *d = *deepen;
    if (!d) return;
    if (d->program) glDeleteProgram(d->program);
    if (d->range_program) glDeleteProgram(d->range_program);
    for (int i = 0; i < SLOTS; i++)
        if (d->slots[i].fence) glDeleteSync(d->slots[i].fence);
    const GLuint buffers[] = {d->rows, d->columns, d->ranges};
    glDeleteBuffers(3, buffers);
    free(d->tables);
    free(d->row);
    free(d->column);
    free(d);
    *deepen = NULL;
}

size_t deepen_gpu_bytes(const struct deepen *d)
{
    return d->bytes;
}

static int64_t wrap(int64_t x, int64_t period)
{
    int64_t r = x % period;
    return r < 0 ? r + period : r;
}

// Are the window's columns those of the tiles in all these rows?
static bool columns_agree(const window_shape *shape, const window *w, int64_t row0, int64_t row1)
{
    if (row0 < 0 || row1 > (int64_t)TILE_SIZE << w->zoom) return false;
    for (int64_t row = row0 / TILE_SIZE; row <= (row1 - 1) / TILE_SIZE; row++)
        if ((int64_t)TILE_SIZE * grid_cols(w->zoom, (int)row) != (int64_t)shape->cols << w->share)
            return false;
    return true;
}

bool deepen_can(const struct deepen *d, const window *w, window_rect rect, const window *coarser)
{
    window_rect needs = window_rect_parents(rect);
    if (coarser->zoom + 1 != w->zoom || coarser->share + 1 != w->share) return false;
    if (!columns_agree(&d->shape, w, rect.row0, rect.row1)) return false;
    if (!columns_agree(&d->shape, coarser, needs.row0, needs.row1)) return false;
    int64_t circle = (int64_t)d->shape.cols << w->share;
    for (int64_t row = rect.row0 / TILE_SIZE; row <= (rect.row1 - 1) / TILE_SIZE; row++)
        for (int64_t col = rect.col0; col < rect.col1;) {
            int64_t at = wrap(col, circle);
            tile_id id = {LAYER_HEIGHT, w->zoom, (int)row, (int)(at / TILE_SIZE)};
            if (!pyramid_derives(d->pyramid, id)) return false;
            col += TILE_SIZE - at % TILE_SIZE;
        }
    return true;
}

static struct row row_of(const struct deepen *d, const window *w, int64_t row)
{
    double lat = grid_lat(w->zoom, row);
    synthesis_lattice l = synthesis_lattice_of(pyramid_synthesis(d->pyramid), w->zoom, lat);
    struct row out = {.scale = l.scale, .hz = l.hz, .z = l.z};
    out.sin_lat = (float)sin(lat);
    out.cos_lat = (float)cos(lat);
    int64_t first = region_first_tap(row);
    for (int i = 0; i < 4; i++) {
        int coalesce = grid_coalesce(w->zoom - 1, (int)((first + i) / TILE_SIZE));
        synthesis_shape s = synthesis_shape_of(w->zoom - 1, coalesce, first + i);
        if (i == 1 || i == 2) out.shape[i - 1] = s.shape;
        out.weight[i] = s.weight;
        out.factor[i] = s.factor;
    }
    return out;
}

static struct column column_of(const struct deepen *d, const window *w, int64_t col)
{
    int64_t circle = (int64_t)d->shape.cols << w->share;
    double lon = ((double)(wrap(col, circle) - circle / 2) + 0.5) * (2 * M_PI / (double)circle);
    return (struct column){cos(lon), sin(lon)};
}

// Gives the tables what they lack of a rectangle: a moving window brings few rows and columns.
// Returns the bytes.
static size_t fill_rows(struct deepen *d, const window *w, window_rect rect)
{
    int64_t *have = d->tables[w->level].rows;
    size_t bytes = 0;
    for (int64_t row = rect.row0; row < rect.row1;) {
        int at = window_texel(row, d->shape.rows), n = 0;
        while (row + n < rect.row1 && at + n < d->shape.rows && have[at + n] != row + n) {
            d->row[n] = row_of(d, w, row + n);
            have[at + n] = row + n;
            n++;
        }
        size_t size = (size_t)n * sizeof *d->row;
        size_t to = d->row_stride * (size_t)w->level + (size_t)at * sizeof *d->row;
        if (n) glNamedBufferSubData(d->rows, (GLintptr)to, (GLsizeiptr)size, d->row);
        bytes += size;
        row += n ? n : 1;
    }
    return bytes;
}

static size_t fill_columns(struct deepen *d, const window *w, window_rect rect)
{
    int64_t *have = d->tables[w->level].columns, circle = (int64_t)d->shape.cols << w->share;
    size_t bytes = 0;
    for (int64_t col = rect.col0; col < rect.col1;) {
        int at = window_texel(col, d->shape.cols), n = 0;
        for (int64_t key; col + n < rect.col1 && at + n < d->shape.cols; n++) {
            key = wrap(col + n, circle) * 32 + w->share;
            if (have[at + n] == key) break;
            d->column[n] = column_of(d, w, col + n);
            have[at + n] = key;
        }
        size_t size = (size_t)n * sizeof *d->column;
        size_t to = d->column_stride * (size_t)w->level + (size_t)at * sizeof *d->column;
        if (n) glNamedBufferSubData(d->columns, (GLintptr)to, (GLsizeiptr)size, d->column);
        bytes += size;
        col += n ? n : 1;
    }
    return bytes;
}

static void bind(GLuint binding, GLuint buffer, size_t at, size_t bytes)
{
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, buffer, (GLintptr)at, (GLsizeiptr)bytes);
}

size_t deepen_make(struct deepen *d, GLuint texture, const window *w, window_rect rect)
{
    const struct planet_meta *m = pyramid_meta(d->pyramid);
    window_rect needs = window_rect_parents(rect);
    synthesis_lattice lattice = synthesis_lattice_of(pyramid_synthesis(d->pyramid), w->zoom, 0);
    int rows = (int)(rect.row1 - rect.row0), cols = (int)(rect.col1 - rect.col0);
    assert(w->level > 0 && rows > 0 && cols > 0);
    size_t bytes = fill_rows(d, w, rect) + fill_columns(d, w, rect);
    synthesis_scale scale = synthesis_scale_of(w->zoom - 1, m->synthesis_gain,
                                               m->max_zoom[LAYER_HEIGHT], m->ellipsoid.a);
    glUseProgram(d->program);
    glBindTextureUnit(0, texture);
    glBindImageTexture(0, texture, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R32F);
    bind(0, d->rows, d->row_stride * (size_t)w->level, d->row_stride);
    bind(1, d->columns, d->column_stride * (size_t)w->level, d->column_stride);
    glUniform4i(0, window_texel(rect.row0, d->shape.rows), window_texel(rect.col0, d->shape.cols),
                rows, cols);
    int odd_row = (int)wrap(rect.row0, 2), odd_col = (int)wrap(rect.col0, 2);
    glUniform4i(1, window_texel(needs.row0 - odd_row, d->shape.rows),
                window_texel(needs.col0 - odd_col, d->shape.cols), odd_row, odd_col);
    glUniform1i(2, w->level);
    glUniform3f(3, scale.steep, scale.least, scale.share);
    glUniform2d(4, lattice.shift[0], lattice.shift[1]);
    glDispatchCompute((GLuint)(cols + 31) / 32, (GLuint)(rows + 3) / 4, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return bytes + 64; // the uniforms
}

size_t deepen_run(struct deepen *d, GLuint texture, const clipmap_strip *strip)
{
    const window *w = &strip->window;
    window_rect rect = strip->rect;
    if (d->busy == SLOTS) return 0;
    struct slot *slot = &d->slots[(d->first + d->busy++) % SLOTS];
    size_t bytes = deepen_make(d, texture, w, rect);
    int rows = (int)(rect.row1 - rect.row0), cols = (int)(rect.col1 - rect.col0);
    int tex_col = window_texel(rect.col0, d->shape.cols), cells = clip_bounds_cells(tex_col, cols);
    glUseProgram(d->range_program);
    bind(0, d->ranges, slot->range, (size_t)rows * (size_t)cells * sizeof(clip_range));
    glUniform4i(0, window_texel(rect.row0, d->shape.rows), tex_col, rows, cols);
    glUniform1i(1, w->level);
    glDispatchCompute((GLuint)cells, (GLuint)(rows + 15) / 16, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                    GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
    slot->strip = *strip;
    slot->fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    return bytes;
}

bool deepen_has_room(const struct deepen *d)
{
    return d->busy < SLOTS;
}

bool deepen_busy(const struct deepen *d)
{
    return d->busy > 0;
}

bool deepen_finished(struct deepen *d, double timeout_s, clipmap_strip *out)
{
    if (!d->busy) return false;
    struct slot *slot = &d->slots[d->first];
    GLenum done = glClientWaitSync(slot->fence, GL_SYNC_FLUSH_COMMANDS_BIT,
                                   (GLuint64)(fmin(fmax(timeout_s, 0), 1e6) * 1e9));
    if (done == GL_TIMEOUT_EXPIRED) return false;
    *out = slot->strip;
    out->ranges = (const clip_range *)(d->map + slot->range);
    return true;
}

void deepen_release(struct deepen *d)
{
    struct slot *slot = &d->slots[d->first];
    assert(d->busy);
    glDeleteSync(slot->fence);
    slot->fence = 0;
    d->first = (d->first + 1) % SLOTS;
    d->busy--;
}
